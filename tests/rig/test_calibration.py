"""Calibration with its uncertainty: amplifier, coil, file and what they change in a rig."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rig.measured_coil import RIG
from tests.rig.wires.process import over_wires_here

from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.records.checks.certificates import Certificates, LengthCertificate, RelativeCertificate
from dampyr.rig import Drive, RigSettings, simulated
from dampyr.rig.calibration import Calibration, calibration_of, load_calibration, save_calibration


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


def test_a_stated_uncertainty_replaces_the_assumed_one_and_a_measured_one_replaces_both() -> None:
    base = RigSettings()
    cell = RelativeCertificate(date(2026, 3, 1), coverage_factor=2.0, uncertainty=1e-3)
    scale, voltage = (
        LengthCertificate(date(2026, 3, 1), uncertainty=1e-6),
        RelativeCertificate(date(2026, 3, 1), uncertainty=2e-3),
    )
    certified = replace(base, certificates=Certificates(load_cell=cell, encoder=scale, coil_voltage=voltage))
    assumed = calibration_of(certified)
    assert calibration_of(base).corrected(base) == base
    stated = assumed.corrected(certified)
    assert stated.load_cell.scale_uncertainty == pytest.approx(5e-4)
    assert stated.encoder.accuracy / 3**0.5 == pytest.approx(1e-6)
    assert stated.supply.reading_uncertainty == pytest.approx(2e-3)
    measured = replace(assumed, scale_uncertainty=3e-3 * assumed.scale).corrected(certified)
    assert measured.load_cell.scale_uncertainty == pytest.approx(3e-3)
