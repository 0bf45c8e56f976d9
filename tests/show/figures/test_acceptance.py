"""Points of an acceptance inside and outside of their band."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS


def test_points_outside_a_band_differ_from_those_inside_by_their_shape() -> None:
    fig = MAKERS["peak_velocity"]()
    by_label = {str(line.get_label()): line for line in fig.axes[0].lines}
    assert [(words, by_label[words].get_marker()) for words in ("inside", "outside", "not judged")] == [
        ("inside", "o"), ("outside", "X"), ("not judged", "s"),
    ]  # fmt: skip
    np.testing.assert_allclose(by_label["outside"].get_xydata(), [[60.0, 90.0]])
    np.testing.assert_allclose(by_label["reference"].get_xydata()[1:-1], [[40.0, 100.0], [80.0, 150.0]])
    (fill,) = fig.axes[0].collections
    corners = {tuple(np.round(corner, 3)) for corner in fill.get_paths()[0].vertices}
    assert {(40.0, 85.0), (40.0, 115.0), (80.0, 127.5), (80.0, 172.5)} <= corners
    used = [line for line in MAKERS["used"]().axes[0].lines if line.get_marker() not in ("", "None")]
    assert {str(line.get_label()) for line in used if line.get_markerfacecolor() == "none"} == {
        "extension, outside", "energy, outside",
    }  # fmt: skip
