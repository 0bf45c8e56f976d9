"""The inverse of a moving average against the raw values that it was taken of."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records.conditioning.moving_average import averaged, reach_of
from dampyr.records.conditioning.smoothing_inverse import undo

T = 0.002 * np.arange(3000)
RNG = np.random.default_rng(7)
SINE = 1e-2 * np.sin(2 * np.pi * 1.03 * T)
NOISY = SINE + 3e-6 * RNG.standard_normal(T.size)


def reference(smoothed, before, after, start):
    """The recursion of the docstring, one sample after the other."""
    size, raw = before + 1 + after, np.empty(smoothed.size)
    raw[:size] = start
    for n in range(before + 1, smoothed.size - after):
        raw[n + after] = raw[n - before - 1] + size * (smoothed[n] - smoothed[n - 1])
    return raw


@pytest.mark.parametrize("trailing", [False, True])
@pytest.mark.parametrize("size", [7, 48])
def test_the_recursion_and_its_start_values(size, trailing):
    before, after = reach_of(size, trailing)
    smoothed = averaged(NOISY, before, after)
    made = undo(smoothed, before, after)
    by_recursion = reference(smoothed, before, after, made.values[:size])
    np.testing.assert_allclose(made.values, by_recursion, atol=1e-11)
    assert made.start == "least second differences"
    # what repeats itself in each window is lost: of white noise its mean over the 3000 / N windows, about 1 um / sqrt(60 / N)
    assert np.std(made.values - NOISY) < 2.0 * 3e-6 / np.sqrt(3000 / size)
    assert made.reliable
    assert made.complete
    assert made.noise == pytest.approx(3e-6, rel=0.3)
    assert made.growth == pytest.approx(size * np.sqrt(2 * 3000 / size))


def test_no_other_start_values_have_smaller_second_differences():
    """A dense solution of the least squares problem, of a short record."""
    before, after, size = 4, 3, 8
    smoothed = averaged(NOISY[:120], before, after)
    values = undo(smoothed, before, after).values
    tile = np.eye(size)[np.arange(120) % size]
    weight = np.sin(np.pi * np.arange(1, 119) / 119)
    zero = reference(smoothed, before, after, np.zeros(size))
    second = weight[:, None] * np.diff(tile, 2, axis=0)
    start = np.linalg.lstsq(second, -weight * np.diff(zero, 2), rcond=None)[0]
    dense = zero + tile @ start
    dense += np.mean((smoothed - averaged(dense, before, after))[before : 120 - after])
    np.testing.assert_allclose(values, dense, atol=1e-12)


def test_a_rest_gives_the_start_values_that_the_rest_of_the_record_does_not():
    """Broad motion has power at 1/T too: lost without a rest, and said so; exact with one."""
    broad = np.cumsum(np.convolve(RNG.standard_normal(4000), np.hanning(60), "same"))[:3000]
    before, after = reach_of(50, False)
    without = undo(averaged(broad, before, after), before, after)
    error = float(np.std(without.values - broad))
    assert not without.complete or error <= 1e-2 * np.std(broad)
    assert without.missing == pytest.approx(error, rel=1.0)
    rested = np.r_[np.zeros(400), broad - broad[0]]
    with_rest = undo(averaged(rested, before, after), before, after, rest=370)
    assert with_rest.start == "rest at the start"
    assert with_rest.missing == 0.0
    np.testing.assert_allclose(with_rest.values, rested, atol=1e-8 * np.ptp(rested))


@pytest.mark.parametrize("decimals", [8, 6])
def test_rounding_that_stays_below_the_noise(decimals):
    before, after = reach_of(50, False)
    made = undo(1e-3 * np.round(1e3 * averaged(NOISY, before, after), decimals), before, after)
    assert made.reliable
    assert np.std(made.values - NOISY) < 1.5e-6


@pytest.mark.parametrize("size", [25, 50, 150])
def test_rounding_that_grows_beyond_the_noise_is_seen(size):
    """Steps of 0.1 um, uniform: 29 nm rms, multiplied by N and summed over the windows from the middle."""
    before, after = reach_of(size, False)
    made = undo(1e-7 * np.round(averaged(NOISY, before, after) / 1e-7), before, after)
    true_error = max(np.std(part) for part in np.array_split(made.values - NOISY, 8))
    assert true_error > 5e-6
    assert not made.reliable
    assert 0.7 * true_error < made.error < 2.0 * true_error  # neighbouring errors alternate


def test_the_grid_of_the_converter_removes_the_rounding():
    """Counts of 5 um, smoothed over 23 samples and rounded to 10 nm, which alone would grow to 1 um."""
    counts = 5e-6 * np.round(SINE / 5e-6)
    before, after = reach_of(23, False)
    smoothed = averaged(np.r_[np.zeros(200), counts], before, after)
    rounded = 1e-8 * np.round(smoothed / 1e-8)
    made = undo(rounded, before, after, rest=180)
    assert made.grid == pytest.approx(5e-6, rel=1e-6)
    np.testing.assert_allclose(made.values, np.r_[np.zeros(200), counts], atol=2e-8)


def test_too_few_windows():
    with pytest.raises(InputError, match="30 samples are fewer than four windows of 9"):
        undo(np.zeros(30), 4, 4)
