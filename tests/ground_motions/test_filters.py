"""Filters: Butterworth's gain of two passes without phase, pads, and the history."""

import numpy as np
import pytest
from tests.ground_motions.motion_at_rest import DT, TIME, N, at_rest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, corrected, el_centro, filtered


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


def test_the_history_tells_everything_in_order() -> None:
    motion = filtered(corrected(el_centro().scaled(2.0)), 0.1, 20.0)
    assert [note.split()[0] for note in motion.history] == ["scaled", "baseline", "Butterworth"]
    assert motion.source == el_centro().source
