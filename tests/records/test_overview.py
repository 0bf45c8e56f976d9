"""Which motions repeat themselves, and what is told of those that do not; forces written side by side."""

import numpy as np
import pytest

from dampyr.records import Record, overview
from dampyr.records.checks.label_checks import creates_energy


def chirp(sign: float = 1.0) -> Record:
    """0.2 to 2 Hz in 10 s, with most of its speed where it is fast."""
    t = 0.005 * np.arange(2001)
    x = 0.01 * np.sin(2 * np.pi * (0.2 * t + 0.09 * t**2))
    return Record(t, x, sign * 800.0 * np.gradient(x, t) + 70.0)


def test_a_sine_repeats_itself(make_sine) -> None:
    seen = overview(make_sine(third=0.1, drift=2e-4))
    assert seen.repeats
    assert seen.dominant_hz == pytest.approx(0.9, abs=0.1)
    assert seen.rms_speed == pytest.approx(0.010 * 2 * np.pi * 0.9 * np.sqrt((1 + 0.09) / 2), rel=0.03)


def test_the_campaign_repeats_itself(published: list[Record]) -> None:
    assert all(overview(record).repeats for record in published)


def test_a_motion_of_many_frequencies_does_not() -> None:
    from tests.stories.laboratory import earthquake

    for seed in (1, 2, 3, 4):
        t, x = earthquake(seed)
        seen = overview(Record(t, x, np.gradient(x, t)))
        assert not seen.repeats
        assert seen.stroke_m == np.ptp(x)
        assert seen.rms_speed == pytest.approx(float(np.sqrt(np.mean(np.gradient(x, t) ** 2))), rel=0.02)


def test_a_sweep_does_not_and_its_work_tells_the_sign() -> None:
    assert not overview(chirp()).repeats
    assert overview(chirp()).work == pytest.approx(
        800.0 * np.trapezoid(np.gradient(chirp().displacement, 0.005) ** 2) * 0.005, rel=0.01
    )
    assert not creates_energy(chirp())
    assert creates_energy(chirp(-1.0))
