"""Loops are in the units that people read."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS, F, V, X


def test_loops_are_in_mm_and_mm_per_s() -> None:
    fig = MAKERS["loops"]()
    left, right = fig.axes
    np.testing.assert_allclose(left.lines[0].get_xdata(), 1e3 * X)
    np.testing.assert_allclose(right.lines[0].get_xdata(), 1e3 * V)
    np.testing.assert_allclose(left.lines[1].get_ydata(), 0.9 * F)
    assert left.get_xlabel() == "displacement [mm]"
    assert right.get_xlabel() == "velocity [mm/s]"
    assert left.get_ylabel() == "force [N]"
