"""Alarms of the bench: latched until they are acknowledged, and limits that are kept."""

import json
from pathlib import Path

import pytest
from tests.console.bench_runs import Phase, Until
from tests.rig_time import RealTime

from dampyr.console.bench_alarms import FILE as LIMITS
from dampyr.console.bench_alarms import Alarms
from dampyr.console.bench_session import Bench
from dampyr.errors import InputError


def test_an_alarm_is_latched_until_it_is_acknowledged(armed: Bench, until: Until, phase: Phase) -> None:
    armed.set_alarm_limit("a", "position", -0.004, 0.004)
    armed.go("a", 0.006)
    until(lambda: bool(armed.state().alarms))
    alarm = armed.state().alarms[0]
    assert alarm.active
    assert "position" in alarm.words
    assert "is above its alarm limit of 4 mm" in alarm.words
    phase(armed, "armed")
    armed.go("a", 0.0)
    until(lambda: not armed.state().alarms[0].active)
    assert len(armed.state().alarms) == 1  # one excursion, one alarm
    assert armed.state().alarms[0].acknowledged == ""
    armed.acknowledge("a")
    assert armed.state().alarms[0].acknowledged == "page 1"
    assert json.loads((armed.data / "bench" / LIMITS).read_text())[0]["high"] == 0.004
    assert Alarms(armed.data / "bench").limits == armed.state().alarm_limits  # the next session has them
    with pytest.raises(InputError, match="low = 5 mm is not below high = 4 mm"):
        armed.set_alarm_limit("a", "position", 0.005, 0.004)
    armed.set_alarm_limit("a", "position", None, None)
    assert armed.state().alarm_limits == ()


def test_limits_that_cannot_be_read_are_said(tmp_path: Path) -> None:
    for text in ("{", '[{"reading": "colour"}]', '[{"reading": "force", "low": "x"}]'):
        (tmp_path / LIMITS).write_text(text)
        alarms = Alarms(tmp_path)
        assert alarms.limits == ()
        assert "set them again" in alarms.alarms[0].words


def test_a_trip_is_an_alarm_and_an_event(bench: Bench, bench_time: RealTime, phase: Phase, until: Until) -> None:
    bench_time.faults = ("broken-cell@2s",)
    bench.connect("a")
    phase(bench, "idle")
    bench.arm("a")
    until(lambda: bool(bench.state().alarms), 20.0)
    assert "load cell signal" in bench.state().alarms[0].words
    phase(bench, "idle", 5.0)
    assert any("load cell signal" in event.what for event in bench.events.recent())
