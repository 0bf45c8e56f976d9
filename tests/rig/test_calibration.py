"""Calibration with its uncertainty: amplifier, coil, file and what they change in a rig."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rig.wires.process import over_wires_here

from dampyr.cli import cli
from dampyr.errors import FileError, InputError, RigFault
from dampyr.rig import Drive, RigSettings, simulated
from dampyr.rig.calibration import Calibration, calibration_of, load_calibration, save_calibration
from dampyr.rig.coil_calibration import fit_coil, measure_coil
from dampyr.rig.load_cell_calibration import Calibrating, step_bandwidth

RIG = replace(RigSettings(), wires=replace(RigSettings().wires, coil_voltage="ai2", coil_current="ai3"))


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


def test_the_coils_heat_is_that_of_the_resistance_that_was_measured() -> None:
    with simulated(RIG) as rig:
        rig.use(replace(calibration_of(RIG), resistance=8.8, resistance_uncertainty=0.1))
        assert rig.warmth.rig.supply.resistance == 8.8


@pytest.mark.parametrize(("resistance", "inductance", "gain"), [(4.4, 0.044, 1.0), (4.0, 0.08, 0.9), (6.0, 0.006, 1.1)])
def test_a_coil_is_identified_from_steps_of_its_voltage(resistance: float, inductance: float, gain: float) -> None:
    true = replace(RIG, supply=replace(RIG.supply, resistance=resistance, inductance=inductance, gain=gain))
    with simulated(RIG, parts=true) as rig:
        coil = measure_coil(rig)
        assert np.ptp(rig.board.simulator.truth.position) < 1e-6  # nothing has moved
        assert rig.board.simulator.truth.voltage[-1] == 0.0
    assert abs(coil.resistance - resistance) < 2.0 * coil.resistance_uncertainty < 0.03 * resistance
    assert abs(coil.inductance - inductance) < 2.0 * coil.inductance_uncertainty < max(0.1 * inductance, 3e-3)
    assert coil.gain is not None
    assert abs(coil.gain - gain) < 2.0 * coil.gain_uncertainty < 0.01 * gain


def test_a_coil_in_closed_form() -> None:
    """One step from rest: i = u/R (1 - exp(-t R/L))."""
    time = np.arange(2000) / 1000.0
    output = np.where((time >= 0.5) & (time < 1.5), 2.0, 0.0)
    rise = 0.5 * (1.0 - np.exp(-np.clip(time - 0.501, 0.0, None) * 4.0 / 0.1))
    fall = np.where(time >= 1.501, np.exp(-np.clip(time - 1.501, 0.0, None) * 4.0 / 0.1), 1.0)
    late = np.concatenate(([0.0], output[:-1]))  # the board's sample sees what was output before it
    coil = fit_coil(RIG, late, late, rise * fall, 20.0)
    assert coil.resistance == pytest.approx(4.0, rel=1e-3)
    assert coil.inductance == pytest.approx(0.1, rel=1e-2)
    warm = fit_coil(RIG, late, late, rise * fall, 45.0)
    assert warm.resistance == pytest.approx(coil.resistance / (1.0 + 0.0039 * 25.0))


def test_a_coil_without_a_shunt_or_without_a_current_is_said_so() -> None:
    with simulated() as rig, pytest.raises(InputError, match=r"wires\.coil_current"):
        measure_coil(rig)
    assert not rig.was_armed
    with (
        simulated(RIG, faults=["open-coil@0s"]) as rig,
        pytest.raises(RigFault, match="the current changed"),
    ):
        measure_coil(rig)


def test_a_calibration_changes_what_the_rig_is_taken_to_be_and_survives_its_file(tmp_path: Path) -> None:
    measured = replace(
        calibration_of(RIG),
        scale=620.0,
        scale_uncertainty=3.1,
        zero_uncertainty=1e-3,
        bandwidth=100.0,
        bandwidth_uncertainty=1.0,
        resistance=4.0,
        resistance_uncertainty=0.02,
        inductance=0.05,
    )
    save_calibration(measured, tmp_path)
    loaded = load_calibration(tmp_path)
    assert loaded == measured
    rig = loaded.corrected(RIG)
    assert (rig.load_cell.scale_uncertainty, rig.load_cell.zero_uncertainty) == pytest.approx((0.005, 0.62))
    assert (rig.load_cell.bandwidth, rig.force_delay) == pytest.approx((100.0, 1.0 / (200.0 * np.pi)))
    assert rig.load_cell.delay_uncertainty == pytest.approx(0.01 / (200.0 * np.pi))
    assert (rig.supply.resistance, rig.supply.resistance_uncertainty, rig.supply.inductance) == (4.0, 0.005, 0.05)
    assert rig.supply.gain_uncertainty == RIG.supply.gain_uncertainty  # it was not measured
    assert loaded.corrected(rig) == rig
    (tmp_path / "rig.toml").write_text("")
    with simulated(tmp_path / "rig.toml") as opened:
        assert opened.settings.supply.resistance == 4.0
        assert opened.board.simulator.settings.supply.resistance == 4.4  # what it really is does not change


def test_a_calibration_of_an_earlier_version_is_read_and_a_wrong_one_refused(tmp_path: Path) -> None:
    old = '[calibration]\nscale = 620.0\nzero = 0.001\ncount = 5e-6\nslope = 100.0\nbase = 0.0\nhow = "shunt"\n[told]\n'
    (tmp_path / "calibration.toml").write_text(old)
    calibration = load_calibration(tmp_path)
    assert calibration == Calibration(620.0, 0.001, 5e-6, how="shunt")
    assert calibration.corrected(RIG) == RIG
    (tmp_path / "calibration.toml").write_text(old.replace("[told]", "resistance = -1.0\n[told]"))
    with pytest.raises(FileError, match=r"calibration\.resistance = -1 ohm is not allowed"):
        load_calibration(tmp_path)
    (tmp_path / "calibration.toml").write_text(old.replace("[told]", "gain_uncertainty = 0.01\n[told]"))
    with pytest.raises(FileError, match=r"gain_uncertainty = 0\.01 is not allowed without gain"):
        load_calibration(tmp_path)
    (tmp_path / "calibration.toml").write_text(old.replace("scale = 620.0", "scale = 0.0"))
    with pytest.raises(FileError, match="scale = 0 N/V is not allowed"):
        load_calibration(tmp_path)


def test_a_reading_says_its_uncertainty() -> None:
    """The spread of zeros over many readings is what each of them states."""
    zeros, stated = [], []
    for seed in range(12):
        with simulated(RIG, seed=seed) as rig:
            steps = Calibrating(rig)
            zeros.append(steps.zero())
            stated.append(steps.calibration.zero_uncertainty)
    assert 0.4 < np.std(zeros) / np.mean(stated) < 2.5


def test_the_command_line_says_each_value_with_its_uncertainty(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text('[wires]\ncoil_voltage = "ai2"\ncoil_current = "ai3"\n')
    arguments = ["calibrate", "--rig", str(tmp_path / "rig.toml"), "--yes", "--coil"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    for row in (
        "load cell's zero",
        "supply's gain",
        "coil's resistance at 20 degC",
        "coil's inductance",
        "standard uncertainty",
    ):
        assert row in result.output
    refused = CliRunner().invoke(cli, [*arguments[:-1], "--amplifier"])
    assert refused.exit_code == 2
    assert "no step of 20 times" in refused.output


def test_a_supply_whose_gain_was_calibrated_gets_its_whole_voltage(tmp_path: Path) -> None:
    """Over the wires: the board's range is that of the gain that was measured."""
    (tmp_path / "rig.toml").write_text("")
    save_calibration(replace(calibration_of(RIG), gain=0.5, gain_uncertainty=0.002), tmp_path)
    voltage = np.concatenate([np.zeros(5), np.full(30, 3.0), np.zeros(5)])
    true = replace(RigSettings(), supply=replace(RigSettings().supply, gain=0.5))
    with over_wires_here(tmp_path / "rig.toml", parts=true) as rig, rig.armed() as table:
        drive = Drive(0.01, np.full(40, table.position), voltage, standing=True)
        assert max(float(samples.voltage.max()) for samples, _ in table.play(drive)) == 3.0


def test_an_encoder_too_fine_for_the_uno_is_said_so() -> None:
    usual = RigSettings()
    encoder, board = replace(usual.encoder, count=1e-6), replace(usual.board, encoder_filter=125e-9)
    fine = replace(usual, encoder=encoder, board=board)
    with (
        simulated(fine) as rig,
        pytest.raises(InputError, match=r"limits\.speed of at most 40 mm/s"),
        rig.armed(),
    ):
        pass
