"""Acceleration, velocity and displacement of a ground motion."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS, V, X


def test_a_ground_motion_is_shown_three_times_in_mm_and_s() -> None:
    acceleration, velocity, displacement = MAKERS["ground"]().axes
    np.testing.assert_allclose(velocity.lines[0].get_ydata(), 1e3 * V)
    np.testing.assert_allclose(displacement.lines[0].get_ydata(), 1e3 * X)
    assert acceleration.get_title(loc="left") == "largest sample 3 m/s² at 0 s"
    assert velocity.get_ylabel() == "velocity [mm/s]"
