"""The load cell's zero, scale, noise and bandwidth with their uncertainty."""

from __future__ import annotations

import numpy as np
import pytest
from tests.rig.measured_coil import RIG

from dampyr.errors import InputError
from dampyr.rig import simulated
from dampyr.rig.load_cell_calibration import Calibrating, step_bandwidth


def step(bandwidth: float, seed: int, slow: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A reading through a filter of one pole, with white noise and a slow error."""
    generator, rate = np.random.default_rng(seed), 20000.0
    time = np.arange(80000) / rate
    volts = 0.3 * (1.0 - np.exp(-np.clip(time - 1.03, 0.0, None) * 2.0 * np.pi * bandwidth))
    walk = np.cumsum(generator.standard_normal(time.size)) / np.sqrt(rate)
    return time, 0.1 + volts + 5e-4 * generator.standard_normal(time.size) + slow * walk


@pytest.mark.parametrize("bandwidth", [20.0, 100.0, 500.0, 1500.0])
def test_the_bandwidth_of_an_amplifier_is_within_its_uncertainty(bandwidth: float) -> None:
    deviations = []
    for seed in range(20):
        value, uncertainty = step_bandwidth(*step(bandwidth, seed))
        deviations.append((value - bandwidth) / uncertainty)
        assert uncertainty < 0.1 * bandwidth
    assert np.sqrt(np.mean(np.square(deviations))) < 1.5


def test_an_amplifier_faster_than_the_board_is_said_to_be_at_least_so_fast() -> None:
    value, uncertainty = step_bandwidth(*step(30000.0, 0))
    assert value == pytest.approx(20000.0 / (2.0 * np.pi))
    assert uncertainty == pytest.approx(0.5 * value)


def test_a_reading_without_a_step_and_one_with_a_bouncing_switch_are_refused() -> None:
    time, volts = step(100.0, 0)
    with pytest.raises(InputError, match="no step of 20 times"):
        step_bandwidth(time, volts[0] + 0.0 * volts + 5e-4 * np.random.default_rng(0).standard_normal(volts.size))
    bouncing = np.where((time > 1.05) & (time < 1.06), 0.1, volts)
    with pytest.raises(InputError, match="does the switch bounce"):
        step_bandwidth(time, bouncing)
    two = 0.6 * volts + 0.4 * np.roll(volts, 400)  # the second one 20 ms later
    with pytest.raises(InputError, match="was it switched twice"):
        step_bandwidth(time, two)
    with pytest.raises(InputError, match="does the switch bounce"):
        step_bandwidth(time, np.where((time > 1.031) & (time < 1.032), 0.1, volts))


def test_a_reading_at_the_end_of_the_boards_range_is_no_calibration() -> None:
    with simulated(RIG, faults=["broken-cell=10@5s"]) as rig:
        steps = Calibrating(rig, 0.5)
        steps.zero()
        rig.board.simulator.run_unattended(6.0)
        before = steps.calibration
        for read in (lambda: steps.loaded("500 N"), lambda: steps.shunted("100 kohm"), steps.zero, steps.amplifier):
            with pytest.raises(InputError, match=r"the cell reads 10 V, which is at the end of the board's range"):
                read()
        assert steps.calibration == before


def test_the_noise_is_that_of_the_scale_that_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    readings = iter([(0.0, 1e-5), (1.0, 1e-5)])
    with simulated(RIG) as rig:
        steps = Calibrating(rig)
        steps.noise = 0.613
        monkeypatch.setattr(steps, "_volts", lambda: next(readings))
        steps.zero()
        steps.loaded("1226 N")
    assert steps.calibration.scale == pytest.approx(1226.0)
    assert steps.calibration.noise == pytest.approx(1.226)


def test_a_reading_says_its_uncertainty() -> None:
    """The spread of zeros over many readings is what each of them states."""
    zeros, stated = [], []
    for seed in range(12):
        with simulated(RIG, seed=seed) as rig:
            steps = Calibrating(rig)
            zeros.append(steps.zero())
            stated.append(steps.calibration.zero_uncertainty)
    assert 0.4 < np.std(zeros) / np.mean(stated) < 2.5
