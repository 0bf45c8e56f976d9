"""Counting cycles while a test runs: the same as sample by sample, whatever the blocks."""

from types import SimpleNamespace

import numpy as np
import pytest

from dampyr.campaigns.monitor import Watch


def by_hand(x: np.ndarray, threshold: float) -> float:
    """Crossings of the middle with a hysteresis, one sample after the other."""
    cycles, side = 0.0, 0
    for each in x:
        now = 1 if each > threshold else -1 if each < -threshold else side
        cycles += 0.5 * (now != side and side != 0)
        side = now
    return cycles


@pytest.mark.parametrize("block", [1, 7, 40, 400])
def test_cycles_are_counted_as_sample_by_sample(block: int) -> None:
    rng = np.random.default_rng(3)
    t = np.arange(4000) / 1000.0
    x = 0.004 * np.sin(2 * np.pi * 2.3 * t) + 1e-4 * rng.normal(size=t.size)
    planned = SimpleNamespace(drive=SimpleNamespace(displacement=x), peak_position=0.004)
    watch = Watch(planned, 1000.0)
    for first in range(0, x.size, block):
        watch.take(SimpleNamespace(displacement=x[first : first + block]))
    assert watch.cycles == by_hand(x, 0.2 * 0.004)
    assert watch.cycles == pytest.approx(2.3 * 4, abs=0.5)
    assert watch.stroke == pytest.approx(np.ptp(x[-1000:]))
