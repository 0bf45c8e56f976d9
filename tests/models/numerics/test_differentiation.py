"""The low-pass beside the derivative: exact on cubics, the stated gain on sines; what a sampling carries.

The derivative itself is in tests/records/test_velocity.py.
"""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.models.numerics.differentiation import carried, differentiate, response, smooth, window

T: np.ndarray = 0.005 * np.arange(601)


@pytest.mark.parametrize("t", [T, np.sort(0.9 * T + 0.1 * np.random.default_rng(0).uniform(0.0, 3.0, T.size))])
def test_a_cubic_goes_through_unchanged_to_its_ends(t: np.ndarray) -> None:
    cubic = 1e3 + 2.0 * t - 1.5 * t**2 + 0.5 * t**3
    np.testing.assert_allclose(smooth(t, cubic, 10.0), cubic, rtol=1e-11)


@pytest.mark.parametrize("frequency", [2.0, 8.0, 14.0])
def test_a_sine_keeps_the_share_that_is_stated(frequency: float) -> None:
    sine: np.ndarray = np.sin(2 * np.pi * frequency * T)
    inner = slice(100, -100)
    np.testing.assert_allclose(smooth(T, sine, 8.0)[inner], float(response(frequency, 8.0)) * sine[inner], atol=1e-4)
    assert float(response(8.0, 8.0)) == pytest.approx(np.sqrt(0.5), rel=1e-12)


def test_windows_one_by_one_give_what_the_convolution_gives() -> None:
    """Samples that are not even are fitted window by window; all but the first are even here."""
    sine: np.ndarray = np.sin(2 * np.pi * 7.0 * T)
    nudged = T.copy()
    nudged[0] -= 1e-4
    np.testing.assert_allclose(smooth(nudged, sine, 8.0)[100:], smooth(T, sine, 8.0)[100:], atol=1e-9)


def test_without_a_bandwidth_it_is_the_central_difference() -> None:
    np.testing.assert_array_equal(differentiate(T, T**2, None), np.gradient(T**2, T))


def test_a_sampling_carries_four_periods_to_a_quarter_of_its_rate() -> None:
    low, high = carried(0.005, 3.0)
    assert (low, high) == pytest.approx((4.0 / 3.0, 50.0))
    width, reach = window(0.005, 10.0)
    assert reach * 0.005 >= 6.0 * width > (reach - 1) * 0.005
    with pytest.raises(InputError, match=r"bandwidth_hz = 60 Hz is not allowed; .* carry from 1\.333 to 50 Hz"):
        smooth(T, T, 60.0)
