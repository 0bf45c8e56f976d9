"""What a rig can do, and the tests of a plan."""

import numpy as np
from tests.show.figures.figure_examples import GRID, PLANNED

from dampyr.show.figures.envelope import envelope


def test_an_envelope_is_in_mm_over_hz_and_crosses_out_what_is_refused() -> None:
    fig = envelope(GRID, {"0 N": 0.01 / GRID}, PLANNED, ([5.0], [0.012]))
    [axes] = fig.axes
    lines = axes.get_lines()
    np.testing.assert_allclose(lines[0].get_ydata(), 10.0 / GRID)
    np.testing.assert_allclose(lines[1].get_xydata(), [[0.5, 10.0], [1.0, 8.0]])
    assert (lines[-1].get_marker(), lines[-1].get_ydata()[0]) == ("x", 12.0)
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
