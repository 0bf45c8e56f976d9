"""The autocorrelation of residuals over the lag."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS, T, lines


def test_the_mean_memory_is_over_the_records_that_have_the_lag() -> None:
    lag, mean = lines(MAKERS["memory"]())["mean"]
    np.testing.assert_allclose(mean[lag < 1.9], 0.5 * (np.exp(-T) + np.cos(9 * T))[T < 1.9], atol=1e-12)
    np.testing.assert_allclose(mean[lag > 2.0], np.exp(-T[T > 2.0]), atol=1e-12)
