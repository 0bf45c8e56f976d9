"""The output of a hysteresis model over its input, with limits on both sides."""

import numpy as np
from tests.show.figures.figure_examples import V, X, lines

from dampyr.show.figures.phase_portrait import phase_portrait
from dampyr.show.figures.style import Axis


def test_curves_are_in_the_units_of_the_axes_and_a_limit_stands_on_both_sides() -> None:
    fig = phase_portrait(Axis("x", "mm", 1e3), Axis("z", "%", 100.0), {"z": (X, V)}, {"bound": 0.5})
    [panel] = fig.axes
    np.testing.assert_allclose(lines(fig)["z"], (1e3 * X, 100.0 * V))
    assert [line.get_ydata()[0] for line in panel.lines[1:]] == [50.0, -50.0]
    assert panel.lines[1].get_label() == "bound"
    assert [text.get_text() for text in fig.legends[0].get_texts()] == ["z", "bound"]  # the limit is named once
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x [mm]", "z [%]")
