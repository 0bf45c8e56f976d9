"""Incremental curves and the fractiles across them."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import SWEEPS, lines

from dampyr.show.figures.incremental import incremental_curves


def test_an_incremental_curve_is_intensity_over_peak_as_it_is() -> None:
    fig = incremental_curves(*SWEEPS, {"50 %": [0.01, 0.02, np.inf]}, limits={"limit": 0.02}, furthest=0.04)
    [axes] = fig.axes
    np.testing.assert_allclose(axes.lines[0].get_xdata(), [10.0, 30.0, 20.0])
    np.testing.assert_allclose(axes.lines[0].get_ydata(), np.array([1.0, 2.0, 3.0]) / 9.80665)
    np.testing.assert_array_equal(lines(fig)["50 %"][0], [10.0, 20.0, np.nan])
    np.testing.assert_allclose(lines(fig)["limit"][0], 20.0)
    assert axes.get_xlim() == pytest.approx((0.0, 40.0))
