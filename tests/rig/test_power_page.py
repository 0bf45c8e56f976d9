"""docs/how-to/power.md has the numbers of the rig's settings, of the firmware and of the simulated plant."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from dampyr.rig import RigSettings
from dampyr.rig.diagnosis import BROWN_OUT
from dampyr.rig.firmware import control_core, twin
from dampyr.rig.settings import FILTERS_IN_EDGES, UNO_REFERENCE

DOCS = Path(__file__).parents[2] / "docs"
TEXT = " ".join((DOCS / "how-to/power.md").read_text("utf-8").split())
RIG = RigSettings()
MOTOR, COIL = RIG.actuator, RIG.supply
PER_NEWTON = (MOTOR.full_load_current - MOTOR.no_load_current) / MOTOR.max_load
BLOCKED = MOTOR.free_speed / MOTOR.droop  # N at which the droop leaves no speed
EDGES = RIG.encoder.count / RIG.limits.speed


@pytest.mark.parametrize(
    "sentence",
    [
        f"| current without load | {MOTOR.no_load_current:g} A |",
        f"| current at {MOTOR.max_load:g} N | {MOTOR.full_load_current:g} A |",
        f"| a blocked table at full duty | {MOTOR.no_load_current + PER_NEWTON * BLOCKED:.1f} A |",
        f"{1e3 * PER_NEWTON:.1f} mA/N times the {BLOCKED:.0f} N",
        f"for the {1e3 * MOTOR.lag:g} ms of the motor's lag | {MOTOR.no_load_current + 2 * PER_NEWTON * BLOCKED:.1f} A |",
        f"| the Uno stops above | {MOTOR.max_current:g} A for {control_core.OVER_TIME} ms |",
        f"{MOTOR.current_scale:g} A/V (`actuator.current_scale`): {MOTOR.max_current:g} A are "
        f"{MOTOR.max_current / MOTOR.current_scale:.2f} V",
        f"{UNO_REFERENCE:g} V are {UNO_REFERENCE * MOTOR.current_scale:g} A",
        f"a fault's 4.5 mA read as {4.5 * MOTOR.current_scale:.0f} A",
        f"{COIL.resistance:g} ohm and {1e3 * COIL.inductance:g} mH: 1 A at {COIL.max_voltage:g} V, with "
        f"{1e3 * 0.5 * COIL.inductance:.0f} mJ in it",
        f"0 to {RIG.command_range[1] / 1.1:g} V (`supply.gain` {COIL.gain:g} V/V)",
        f"With 12 V and 1 A through the coil it turns {12.0 - COIL.resistance:.1f} W into heat",
        f"R = 33.75 kohm gives {15000 * 4.75 / (13750 + 33750):.1f} A, R = 57.5 kohm {15000 * 4.75 / (13750 + 57500):.1f} A",
        f"reads as {twin.SHIPPED_FUSE:02X}: reset below {BROWN_OUT[twin.SHIPPED_FUSE & 7]} V",
        f"FC is a reset below {BROWN_OUT[0xFC & 7]} V",
        f"shorter than {1e6 * RIG.board.encoder_filter:g} us",
        f"{1e6 * EDGES:.1f} us apart at {1e3 * RIG.limits.speed:g} mm/s (`limits.speed`)",
        f"a third of that at most: {1e6 * EDGES / FILTERS_IN_EDGES:.1f} us",
        f"(one each {1e3 * RIG.board.block:g} ms)",
    ],
)
def test_its_numbers_are_those_of_the_rig(sentence: str) -> None:
    assert sentence in TEXT


def test_its_fuse_is_between_full_load_and_the_trip() -> None:
    (fuse,) = {float(size) for size in re.findall(r"slow fuse of (\d+) A", TEXT)}
    (supply,) = {float(size) for size in re.findall(r"supply of (\d+) A or more", TEXT)}
    assert MOTOR.full_load_current < fuse < MOTOR.max_current
    assert MOTOR.full_load_current < supply


def test_the_settings_that_it_names_are_there() -> None:
    for part, name in re.findall(r"`(actuator|wires|supply|board|limits)\.(\w+)", TEXT):
        assert hasattr(getattr(RIG, part), name), f"{part}.{name}"


def test_other_pages_lead_to_it() -> None:
    for page in ("index.md", "how-to/firmware.md", "how-to/rig.md"):
        assert "power.md" in (DOCS / page).read_text("utf-8"), page
