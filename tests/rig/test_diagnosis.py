"""What doctor says of a rig."""

from __future__ import annotations

from dataclasses import replace
from datetime import date, timedelta

import pytest
from tests.rig.table import settings

from dampyr.records.checks.certificates import Certificates, LengthCertificate, RelativeCertificate
from dampyr.rig.diagnosis import _motor, _program, _settings, diagnose
from dampyr.rig.instruments.contract import Program
from dampyr.rig.settings import RigSettings, Wires
from dampyr.rig.settings_file import write_settings


def test_a_rig_without_switches_is_told_so(tmp_path) -> None:
    for wired in (False, True):
        path = write_settings(settings(wired, wired, index="ctr1/PFI9" if wired else ""), tmp_path / "rig.toml")
        repairs = {each.what: each.repair for each in diagnose(path)}
        for what in ("end switches", "emergency stop", "encoder's index"):
            assert (repairs[what] is None) == wired
    assert "end switches now" not in repairs


@pytest.mark.parametrize(
    ("fuse", "words", "low"),
    [
        (0xFD, "resets below 2.7 V", True),
        (0x05, "resets below 2.7 V", True),
        (0xFC, "resets below 4.3 V", False),
        (0xFF, "off", True),
    ],
)
def test_the_brown_out_of_the_uno_is_read_from_its_fuse(fuse: int, words: str, low: bool) -> None:
    """The BODLEVEL table of the chip's data sheet; the chip needs 4.5 V at 16 MHz."""
    checks = {check.what: check for check in _program(RigSettings(), Program(False, 250000, "00", True, fuse))}
    brown_out = checks["Uno's brown-out"]
    assert words in brown_out.observed
    assert (brown_out.repair is not None) is low
    if low:
        assert "extended fuse to FC" in brown_out.repair


def test_a_fuse_that_means_nothing_was_not_read() -> None:
    checks = {check.what: check for check in _program(RigSettings(), Program(False, 250000, "00", True, 0x02))}
    assert "could not read it" in (checks["Uno's brown-out"].repair or "")


def test_a_program_of_other_sources_or_for_another_bridge_is_told() -> None:
    checks = {check.what: check for check in _program(RigSettings(), Program(True, 115200, "0badf00d", False, 0xFC))}
    assert checks["Uno's program"].observed == "115200 baud, sources 0badf00d, not of this dampyr"
    assert "flash" in (checks["Uno's program"].repair or "")
    assert "make firmware DIRECTION_PIN=0" in (checks["bridge"].repair or "")


def test_a_current_of_the_motor_that_nothing_reads_is_told() -> None:
    unread, read = (
        {check.what: check for check in _motor(RigSettings(wires=Wires(bridge_current=wired)))}
        for wired in (False, True)
    )
    assert "wire the bridge's R_IS and L_IS to A0 and A1" in (unread["motor's current"].repair or "")
    assert (read["motor's current"].observed, read["motor's current"].repair) == ("read, stops above 20 A", None)


def test_certificates_are_told_and_one_that_has_expired_is_to_be_repaired() -> None:
    today = date.today()
    valid = RelativeCertificate(today - timedelta(30), today + timedelta(30), "4711", uncertainty=1e-3)
    expired = LengthCertificate(today - timedelta(30), today - timedelta(1))
    rig = replace(RigSettings(), certificates=Certificates(load_cell=valid, encoder=expired))
    checks = {check.what: check for check in _settings(rig, None)}
    assert checks["load cell's certificate"].repair is None
    assert "no. 4711" in checks["load cell's certificate"].observed
    assert "have it calibrated" in (checks["encoder's certificate"].repair or "")
    assert not any("certificate" in check.what for check in _settings(RigSettings(), None))
