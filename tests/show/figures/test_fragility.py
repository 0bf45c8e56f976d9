"""Fragility curves, their bands and the counted shares."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import FRAGILE, lines

from dampyr.show.figures.fragility import fragility_curves


def test_a_fragility_is_in_g_and_per_cent_and_one_without_a_curve_shows_its_points() -> None:
    fig = fragility_curves(FRAGILE)
    x, y = lines(fig)["0 V"]
    np.testing.assert_allclose((x[-1], y[-1]), (9.0 / 9.80665, 100.0))
    x, y = lines(fig)["no curve"]
    np.testing.assert_allclose(x, np.array([1.0, 5.0]) / 9.80665)
    np.testing.assert_array_equal(y, 0.0)
    [band] = fig.axes[0].collections
    assert band.get_paths()[0].get_extents().y1 == pytest.approx(100.0 * 9.0 / 8.0)
