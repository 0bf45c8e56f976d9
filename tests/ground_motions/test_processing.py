"""Processing does what it says, keeps the original, and notes itself in the history."""

import warnings

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import GroundMotion, corrected, el_centro, filtered, padded, resampled, trimmed
from dampyr.ground_motions.intensity_measures import arias, sa, significant_duration
from dampyr.ground_motions.resampling import above

N, DT = 4001, 0.01
TIME = np.arange(N) * DT


def at_rest() -> GroundMotion:
    """A motion whose velocity and displacement are known and end at 0: d = t^3 (T - t)^3 sin(2 pi t), in double precision."""
    T = TIME[-1]
    x = np.polynomial.Polynomial([0, 0, 0, T**3, -3 * T**2, 3 * T, -1]) * T**-6.0
    w = 2 * np.pi
    s, c = np.sin(w * TIME), np.cos(w * TIME)
    return GroundMotion(x.deriv(2)(TIME) * s + 2 * w * x.deriv()(TIME) * c - w**2 * x(TIME) * s, DT, source="made")


@pytest.mark.parametrize("degree", [1, 2, 4])
def test_a_baseline_of_the_degree_is_taken_off_whole(degree: int) -> None:
    motion = corrected(at_rest(), degree)
    drift = np.polynomial.Polynomial([0.02, -0.001, 3e-5, 2e-6, 1e-7][: degree + 1])
    bent = GroundMotion(motion.acceleration + drift(TIME), DT)
    assert abs(bent.displacement[-1]) > 1.0
    np.testing.assert_allclose(corrected(bent, degree).acceleration, motion.acceleration, atol=1e-11)


def test_a_corrected_motion_ends_at_rest_where_it_began() -> None:
    for degree in (1, 2, 3, 6):
        motion = corrected(el_centro(), degree)
        assert abs(motion.velocity[-1]) < 1e-12
        assert abs(motion.displacement[-1]) < 1e-12
    assert "baseline of degree 6" in motion.history[0]
    assert el_centro().history == ()


def test_without_the_ends_the_velocity_is_smaller_still() -> None:
    raw, free, tied = el_centro(), corrected(el_centro(), 2, at_rest=False), corrected(el_centro(), 2)
    sizes = [float(np.sum(m.velocity**2)) for m in (free, tied, raw)]
    assert sizes[0] < sizes[1] < sizes[2] * 1.01
    worse = free.acceleration + 1e-5 * (TIME[: free.n] / 31.18)
    assert np.sum(GroundMotion(worse, 0.02).velocity ** 2) > sizes[0], "the least is a least"


def test_a_filter_has_the_gain_of_two_passes_and_no_phase() -> None:
    motion = GroundMotion(np.exp(-0.5 * ((TIME - 20) / 2) ** 2) * np.sin(2 * np.pi * 1.0 * (TIME - 20)), DT)
    near = 1 / (1 + 0.8**8)  # Butterworth's formula, order 4, squared by the second pass
    for low, high, gain in ((1.0, None, 0.5), (None, 1.0, 0.5), (0.8, None, near), (None, 1.25, near)):
        out = filtered(motion, low, high, order=4, keep_pads=False)
        assert out.pga == pytest.approx(gain * motion.pga, rel=0.03)
        shift = np.argmax(np.correlate(out.acceleration, motion.acceleration, "same")) - N // 2
        assert shift == 0
    band = filtered(motion, 0.2, 5.0, keep_pads=False)
    assert band.pga == pytest.approx(motion.pga, rel=1e-3)
    assert band.history == (
        "Butterworth band-pass from 0.2 to 5 Hz, order 4, forward and backward, 15 s of pads cut off",
    )
    assert band.n == motion.n


def test_a_high_pass_takes_the_drift_and_its_pads_keep_what_rings() -> None:
    drifting = GroundMotion(at_rest().acceleration + 0.01, DT)
    out = filtered(drifting, low=0.1)
    assert abs(drifting.displacement[-1]) > 5.0
    assert abs(out.displacement[-1]) < 1e-2
    assert (out.n - N) * DT == pytest.approx(2 * 0.75 * 4 / 0.1)
    assert "30 s more at each end" in out.history[0]


def test_a_filtered_record_ends_near_where_it_began_unless_its_pads_are_cut_off() -> None:
    """El Centro from 0.1 to 20 Hz: its displacement is that of the spectrum between the corners."""
    raw = corrected(el_centro())
    motion, cut = filtered(raw, 0.1, 20.0), filtered(raw, 0.1, 20.0, keep_pads=False)
    assert abs(motion.displacement[-1]) < 0.01 * np.abs(motion.displacement).max()
    assert abs(cut.displacement[-1]) > 0.5
    pad = round(30.0 / raw.dt)
    np.testing.assert_array_equal(motion.acceleration[pad:-pad], cut.acceleration)
    n = 2**15
    omega = 2 * np.pi * np.fft.rfftfreq(n, raw.dt)
    with np.errstate(divide="ignore"):
        gain = 1 / (1 + (0.2 * np.pi / omega) ** 8) / (1 + (omega / (40 * np.pi)) ** 8)
    shifted = np.fft.irfft(-np.fft.rfft(raw.acceleration, n) * gain / np.maximum(omega, 1e-3) ** 2, n)
    expected = np.roll(shifted, pad)[: motion.n]
    np.testing.assert_allclose(motion.displacement, expected, atol=0.02 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("low", "high", "order", "words"),
    [
        (None, None, 4, "give one or both, 0 < low < high < 50 Hz"),
        (5.0, 1.0, 4, "low = 5.0 and high = 1.0 Hz are not allowed"),
        (None, 50.0, 4, "half the sampling rate"),
        (-1.0, None, 4, "low = -1.0"),
        (1.0, None, 0, "order = 0 is not allowed; it must be a whole number from 1 to 10"),
    ],
)
def test_a_filter_that_makes_no_sense_is_refused(low: float, high: float, order: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        filtered(at_rest(), low, high, order)


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


def test_cutting_keeps_the_share_and_whole_samples() -> None:
    motion = el_centro()
    cut = trimmed(motion, 0.05, 0.95)
    assert 0.9 * arias(motion) <= arias(cut) < 0.91 * arias(motion)
    assert significant_duration(motion) <= cut.duration <= significant_duration(motion) + 2 * 0.02
    start = round(float(cut.history[0].split()[2]) / 0.02)
    np.testing.assert_array_equal(cut.acceleration, motion.acceleration[start : start + cut.n])
    wider = trimmed(motion, 0.05, 0.95, margin=1.0)
    assert wider.duration == pytest.approx(cut.duration + 2.0, abs=1e-9)
    np.testing.assert_array_equal(trimmed(motion, 0.0, 1.0, margin=99.0).acceleration, motion.acceleration)


def test_rest_is_added_in_whole_samples() -> None:
    motion = el_centro()
    longer = padded(motion, 5.0, before=0.03)
    assert longer.n == motion.n + 250 + 2
    np.testing.assert_array_equal(longer.acceleration[2:-250], motion.acceleration)
    assert not longer.acceleration[-250:].any()
    assert longer.history == ("5 s of rest added after and 0.04 s before",)
    with pytest.raises(InputError, match="seconds = -1 s is not allowed"):
        padded(motion, -1.0)
    with pytest.raises(InputError, match="margin = -1 s"):
        trimmed(motion, margin=-1.0)


def test_scaling_to_a_peak_or_to_a_spectral_value() -> None:
    motion = el_centro()
    assert motion.scaled_to_pga(2.5).pga == pytest.approx(2.5, rel=1e-14)
    scaled = motion.scaled_to_sa(4.0, 0.48, 0.03)
    assert sa(scaled, 0.48, 0.03) == pytest.approx(4.0, rel=1e-13)
    assert motion.scaled_to_sa(4.0, 0.0).pga == pytest.approx(4.0)
    assert scaled.history[-1].startswith("scaled by ")
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match=r"a PGA of .* is not allowed; it must be greater than 0"):
            motion.scaled_to_pga(wrong)
    with pytest.raises(InputError, match="cannot be reached by scaling: the motion is 0"):
        GroundMotion(np.zeros(9), 0.1).scaled_to_sa(1.0, 0.5)


def test_the_history_tells_everything_in_order() -> None:
    motion = filtered(corrected(el_centro().scaled(2.0)), 0.1, 20.0)
    assert [note.split()[0] for note in motion.history] == ["scaled", "baseline", "Butterworth"]
    assert motion.source == el_centro().source


@pytest.mark.parametrize("degree", [0, 7, 1.5])
def test_a_baseline_of_no_sense_is_refused(degree: float) -> None:
    with pytest.raises(InputError, match="a whole number from 1 to 6"):
        corrected(el_centro(), degree)
    with pytest.raises(InputError, match="too few for a baseline"):
        corrected(GroundMotion(np.ones(5), 0.1))
