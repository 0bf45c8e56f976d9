"""The motor's current: read where the bridge's outputs are wired, and what is told where it is too large or not read."""

from __future__ import annotations

from dataclasses import replace

import pytest

import dampyr as dp
from dampyr import campaigns
from dampyr.campaigns.record_test import motor_current_source
from dampyr.errors import RigFault
from dampyr.rig import RigSettings

CAMPAIGN = """
name = "current"
rest_between = "1 s"
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "1 Hz"
voltage = "1.98 V"
cycles = 1
"""


def wired(**motor: float) -> RigSettings:
    rig = RigSettings()
    return replace(rig, wires=replace(rig.wires, bridge_current=True), actuator=replace(rig.actuator, **motor))


def test_a_record_says_whether_the_motors_current_was_read() -> None:
    assert motor_current_source(RigSettings()).startswith("not read")
    assert motor_current_source(wired()) == "read by the Uno, which stops above 20 A"


@pytest.mark.prove
def test_a_record_has_the_largest_current_of_its_motor(tmp_path) -> None:
    """Between that without load and that of the check's envelope; the damper brakes with some 600 N."""
    (tmp_path / "c.toml").write_text(CAMPAIGN)
    with dp.rig.simulated(wired()) as rig:
        (record,) = campaigns.perform(tmp_path / "c.toml", rig, tmp_path / "out")
    assert 2.4 < float(record.provenance["motor_current_largest_A"]) < 13.2


def test_a_current_above_the_largest_stops_the_rig_and_is_told_by_name() -> None:
    """2.5 A are hardly more than the 2.4 A that a motor takes without load: the first motion passes them."""
    with dp.rig.simulated(wired(max_current=2.5)) as rig, pytest.raises(RigFault) as raised, rig.armed() as table:
        table.home()
    assert "the motor's current was above actuator.max_current" in str(raised.value)
