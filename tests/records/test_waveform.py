"""Sines, sweeps and earthquakes told apart."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import el_centro
from dampyr.records import Record
from dampyr.records.cycle_analysis.waveform import waveform


def record(t: np.ndarray, x: np.ndarray) -> Record:
    return Record(time=t, displacement=x, force=np.gradient(x, t) * 900.0, voltage=1.0, name="r")


def test_a_distorted_and_drifting_sine_is_a_sine() -> None:
    t = np.linspace(0.0, 20.0, 4000)
    phase = 2 * np.pi * 0.8 * t
    assert waveform(record(t, 0.01 * np.sin(phase) + 0.001 * np.sin(3 * phase) + 5e-4 * t)) == "sine"


def test_a_sweep_up_or_down_is_a_sweep() -> None:
    t = np.linspace(0.0, 30.0, 9000)
    up = 0.01 * np.sin(2 * np.pi * (0.2 * t + 0.05 * t**2))
    assert waveform(record(t, up)) == "sweep"
    assert waveform(record(t, up[::-1])) == "sweep"


def test_an_earthquake_is_random() -> None:
    motion = el_centro()
    drift = np.cumsum(np.cumsum(motion.acceleration - motion.acceleration.mean())) * motion.dt**2
    smooth = drift - np.polyval(np.polyfit(motion.time, drift, 5), motion.time)
    assert waveform(record(motion.time, smooth)) == "random"


def test_the_campaign_is_made_of_sines(published_fits: list[Record]) -> None:
    assert {waveform(r) for r in published_fits} == {"sine"}


def test_a_record_is_cut_and_thinned_by_name() -> None:
    t = np.linspace(0.0, 2.0, 201)
    whole = record(t, 0.01 * np.sin(9 * t))
    assert whole.until(1.0).time[-1] == pytest.approx(1.0)
    assert whole.until(1.0).name == "r"
    thin = whole.thinned(4)
    assert thin.n == 51
    assert thin.force[1] == whole.force[4]
    assert "4th" in thin.history[-1]
    with pytest.raises(InputError, match="nothing is left before"):
        whole.until(-1.0)
    with pytest.raises(InputError, match="at least 1"):
        whole.thinned(0)
