"""Noise of channels: the quantum of rounded values, and levels without the noise of their channel."""

import numpy as np
import pytest

from dampyr.records import Record
from dampyr.records.checks.channel_noise import quantum
from dampyr.records.checks.quality import flat_levels, quality


@pytest.mark.parametrize("step", [5e-6, 1e-3, 0.1873073])
def test_the_quantum_of_rounded_values(step):
    values = np.random.default_rng(4).normal(0, 40 * step, 2000)
    assert quantum(np.round(values / step) * step) == pytest.approx(step, rel=1e-6)
    assert quantum(values) is None
    assert quantum(np.ones(100)) is None


@pytest.mark.parametrize("step", [0.0, 0.2])
@pytest.mark.parametrize("noise", [0.3, 1.0])
def test_a_level_without_the_noise_of_its_channel_is_flat(step: float, noise: float) -> None:
    """Clipped after the noise, at the quantile of a known share; before the noise it is a plateau as friction gives."""
    t = np.arange(20_000) / 1000.0
    draw, wave = noise * np.random.default_rng(4).standard_normal(t.size), 300.0 * np.sin(2 * np.pi * 0.83 * t)

    def read(values: np.ndarray) -> np.ndarray:
        return np.round(values / step) * step if step else values

    assert flat_levels(read(wave + draw), slice(None), step) == []
    assert flat_levels(read(np.clip(wave, -200.0, 200.0) + draw), slice(None), step) == []
    levels = flat_levels(read(np.clip(wave + draw, -1e3, 200.0)), slice(None), step)
    assert [level for level, _ in levels] == pytest.approx([200.0], abs=0.5)
    share = 0.5 - np.arcsin(200.0 / 300.0) / np.pi  # of a sine that is above two thirds of its peak
    assert np.mean(levels[0][1]) == pytest.approx(share, abs=0.01)


def test_a_channel_without_noise_has_no_flat_level() -> None:
    """Nothing tells its flat tops from friction; and a range of 1e12 steps takes no memory."""
    t = np.arange(5000) / 1000.0
    assert flat_levels(np.clip(np.sin(6.0 * t), -0.5, 0.5), slice(None), 0.0) == []
    wide = 1e9 * np.sin(6.0 * t) + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    assert flat_levels(wide, slice(None), 1e-3) == []


def test_samples_that_repeat_in_each_cycle_stand_nowhere() -> None:
    """An exact sine of 100 samples a cycle, rounded as a text file has it: no value comes twice in a row."""
    t = np.arange(1200) / 200.0
    x, v = 0.02 * np.sin(4.0 * np.pi * t), 0.02 * 4.0 * np.pi * np.cos(4.0 * np.pi * t)
    force = np.round(np.where(v > 0.0, 2000.0, 800.0) * v, 3)
    record = Record(np.round(t, 3), np.round(x, 6), force, voltage=0.0)
    assert quality(record).saturated == {}


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.1, 0.3])
@pytest.mark.parametrize("step", [0.0, 0.2])
def test_friction_is_no_flat_level_whatever_its_noise(noise: float, step: float) -> None:
    """Constant over the stroke but for what turns it round, also where the converter's steps hide the noise."""
    t = np.arange(20_000) / 1000.0
    draw = noise * np.random.default_rng(2).standard_normal(t.size)
    for knee in (1e-3, 0.1):
        force = 80.0 * np.tanh(np.cos(2 * np.pi * 0.3 * t) / knee) + draw
        assert flat_levels(np.round(force / step) * step if step else force, slice(None), step) == []
