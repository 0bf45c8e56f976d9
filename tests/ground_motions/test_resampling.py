"""Resampling: exact where it divides, by name where it does not, and what a longer step loses."""

import warnings

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import GroundMotion, el_centro, resampled
from dampyr.ground_motions.intensity_measures import arias
from dampyr.ground_motions.resampling import above

N, DT = 4001, 0.01
TIME = np.arange(N) * DT


def test_a_whole_division_of_the_step_changes_nothing() -> None:
    motion = el_centro()
    fine = resampled(motion, 0.005)
    assert (fine.n, fine.dt) == (4 * 1559 + 1, 0.005)
    np.testing.assert_array_equal(fine.acceleration[::4], motion.acceleration)
    np.testing.assert_allclose(fine.displacement[::4], motion.displacement, rtol=1e-10, atol=1e-13)
    assert arias(fine) == pytest.approx(arias(motion), rel=1e-13)
    assert fine.history == ("resampled exactly from 0.02 s to 0.005 s",)
    third = resampled(motion, 0.02 / 3)
    assert third.n == 3 * 1559 + 1
    np.testing.assert_allclose(third.acceleration[::3], motion.acceleration, atol=1e-12)


def test_another_step_must_be_asked_for_by_name() -> None:
    for dt in (0.03, 0.015, 0.04):
        with pytest.raises(InputError, match="say how='linear' or how='band-limited'"):
            resampled(el_centro(), dt)
    with pytest.raises(InputError, match="choose from linear, band-limited"):
        resampled(el_centro(), 0.03, "cubic")
    with pytest.raises(InputError, match="not in a ratio of whole numbers up to 1000"):
        resampled(el_centro(), 0.02 * np.pi / 2, "band-limited")
    with pytest.raises(InputError, match="longer than the motion"):
        resampled(el_centro(), 60.0, "linear")
    with pytest.raises(InputError, match="greater than 0"):
        resampled(el_centro(), 0.0)


def tones(frequencies: tuple[float, ...]) -> GroundMotion:
    window = np.exp(-0.5 * ((TIME - 20) / 4) ** 2)
    return GroundMotion(window * sum(np.sin(2 * np.pi * f * TIME) for f in frequencies), DT)


def test_a_longer_step_takes_out_or_folds_and_says_what_is_lost() -> None:
    slow, both = tones((2.0,)), tones((2.0, 23.0))
    with pytest.warns(DampyrWarning, match=r"50 % of the Arias intensity lies above 12.5 Hz and is taken out"):
        filtered = resampled(both, 0.04, "band-limited")
    middle = slice(100, 900)
    np.testing.assert_allclose(filtered.acceleration[middle], slow.acceleration[::4][middle], atol=3e-3)
    assert "taken out" in filtered.history[0]
    with pytest.warns(DampyrWarning, match="folded into lower ones"):
        folded = resampled(both, 0.04, "linear")
    np.testing.assert_array_equal(folded.acceleration, both.acceleration[::4])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "0 % of the Arias" in resampled(slow, 0.04, "band-limited").history[0].replace("e-", "0 % of the Arias")


def test_the_share_above_a_frequency_counts_the_mean_once_and_tones_twice() -> None:
    """A tone of sqrt(2) beside its mean of 1: half of the mean square each."""
    assert above(GroundMotion(1 + np.sqrt(2) * np.cos(2 * np.pi * 10.0 * TIME), DT), 5.0) == pytest.approx(
        0.5, abs=2e-3
    )


def test_a_shorter_step_that_does_not_divide() -> None:
    slow = tones((2.0,))
    exact = lambda t: np.exp(-0.5 * ((t - 20) / 4) ** 2) * np.sin(4 * np.pi * t)  # noqa: E731
    fine = resampled(slow, 0.008, "band-limited")
    np.testing.assert_allclose(fine.acceleration, exact(fine.time), atol=2e-3)
    assert fine.duration <= slow.duration
    linear = resampled(slow, 0.008, "linear")
    np.testing.assert_allclose(linear.acceleration, np.interp(linear.time, TIME, slow.acceleration), atol=1e-12)
