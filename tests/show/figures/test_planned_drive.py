"""The drive of a planned test."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import T, X

from dampyr.show.figures.planned_drive import planned_drive


def test_a_planned_drive_shows_the_speed_between_its_set_points() -> None:
    fig = planned_drive(T, X, np.ones_like(T))
    speed = fig.axes[1].get_lines()[0].get_ydata()
    assert np.abs(speed).max() == pytest.approx(12.0 * np.pi, rel=1e-3)
