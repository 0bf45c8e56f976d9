"""Noise of a load cell's chain: that of white noise, whatever the force does, and less where an amplifier is slow."""

import numpy as np
import pytest
from scipy.signal import lfilter

from dampyr.rig import RigSettings
from dampyr.rig.cell_noise import least_noise

RATE, STEP = 1000.0, RigSettings().step
NOISE = 6.5e-4  # V: 0.4 N


def reading(seed: int = 1, slow: float | None = None) -> np.ndarray:
    t = np.arange(4000) / RATE
    noise = NOISE * np.random.default_rng(seed).standard_normal(t.size)
    if slow is not None:
        decay = np.exp(-2.0 * np.pi * slow / RATE)
        noise = lfilter([1.0 - decay], [1.0, -decay], noise)
    return STEP * np.round((0.3 * np.tanh(20.0 * np.sin(2.0 * np.pi * t)) + noise) / STEP)


def test_the_noise_of_a_reading_is_found_beside_a_force_that_turns() -> None:
    assert least_noise(reading(), RATE, STEP) == pytest.approx(NOISE, rel=0.2)


def test_a_slow_amplifier_lets_less_of_its_noise_through() -> None:
    assert least_noise(reading(slow=30.0), RATE, STEP) < 0.5 * NOISE


def test_vibration_in_a_part_of_a_reading_does_not_count() -> None:
    volts = reading()
    volts[2000:] += 0.01 * np.random.default_rng(2).standard_normal(2000)
    assert least_noise(volts, RATE, STEP) == pytest.approx(NOISE, rel=0.2)


@pytest.mark.parametrize(("volts", "rate"), [(reading()[:100], RATE), (reading(), 100.0), (np.zeros(4000), RATE)])
def test_where_the_noise_is_not_known_nothing_is_said(volts: np.ndarray, rate: float) -> None:
    assert np.isnan(least_noise(volts, rate, STEP))
