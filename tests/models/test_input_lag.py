"""An input that follows its command: a ramp, a constant and no lag in closed form."""

import numpy as np

from dampyr.models.input_lag import lagged


def test_a_ramp_is_followed_tau_behind() -> None:
    t = np.sort(np.random.default_rng(0).uniform(0.0, 2.0, 300))
    expected = 3.0 * (t - t[0] - 0.1 + 0.1 * np.exp(-(t - t[0]) / 0.1))
    np.testing.assert_allclose(lagged(t, 3.0 * (t - t[0]), 0.1), expected, atol=1e-12)


def test_a_constant_command_and_no_lag_change_nothing() -> None:
    t = np.linspace(0.0, 1.0, 50)
    u = np.sin(9 * t)
    assert lagged(t, u, 0.0) is u
    np.testing.assert_allclose(lagged(t, np.full(50, 1.7), 0.2), 1.7, atol=1e-14)
