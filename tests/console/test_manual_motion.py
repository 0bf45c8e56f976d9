"""Motions by hand: to a position, a sine, a voltage on the coil; checked as a test is."""

import numpy as np
import pytest
from tests.console.bench_runs import Phase, Until
from tests.rig_time import RealTime

from dampyr.console.bench_session import Bench
from dampyr.errors import InputError


def test_go_to_a_position_and_end_it(armed: Bench, bench_time: RealTime, until: Until, phase: Phase) -> None:
    armed.go("a", 0.010)
    phase(armed, "moving")
    phase(armed, "armed")
    live = armed.state().live
    assert live is not None
    assert live.position == pytest.approx(0.010, abs=3e-4)
    armed.go("a", -0.020)
    until(lambda: (now := armed.state().live) is not None and now.position < 0.008)
    armed.halt("a")
    phase(armed, "armed", 5.0)
    assert armed.state().note == "ended by the operator"
    assert armed.state().live is not None
    assert armed.state().live.position > -0.015  # type: ignore[union-attr]
    with pytest.raises(InputError, match="position = 50 mm is not allowed; the table goes from -3"):
        armed.go("a", 0.050)
    armed.clients.join("b")
    with pytest.raises(InputError, match="page 1 holds control"):
        armed.go("b", 0.0)


def test_a_motion_that_is_halted_before_it_begins_does_not_begin(armed: Bench, phase: Phase) -> None:
    armed.go("a", 0.010)
    armed.halt("a")
    phase(armed, "armed", 5.0)
    assert armed.state().note == "ended by the operator"
    live = armed.state().live
    assert live is not None
    assert abs(live.position) < 0.003


def test_nothing_goes_to_a_position_without_homing(idle: Bench, phase: Phase) -> None:
    idle.arm("a")
    phase(idle, "armed")
    with pytest.raises(InputError, match="not homed"):
        idle.go("a", 0.001)
    with pytest.raises(InputError, match="not homed"):
        idle.sine("a", 0.002, 1.0, 0.0, 2)


def test_a_sine_by_hand_is_checked_as_a_test_is(armed: Bench, until: Until, phase: Phase) -> None:
    armed.reset_extremes("a")
    armed.sine("a", 0.003, 1.0, 0.5, 2)
    phase(armed, "moving")
    phase(armed, "armed")
    extremes = armed.state().extremes
    assert extremes["position"].high == pytest.approx(0.003, abs=4e-4)
    assert extremes["position"].low == pytest.approx(-0.003, abs=4e-4)
    assert extremes["voltage"].high == pytest.approx(0.5, abs=0.02)
    assert extremes["velocity"].high == pytest.approx(2 * np.pi * 0.003, rel=0.3)
    with pytest.raises(InputError, match="lower the amplitude"):
        armed.sine("a", 0.030, 2.0, 0.0, 2)
    with pytest.raises(InputError, match="cycles = 0"):
        armed.sine("a", 0.003, 1.0, 0.0, 0)


def test_a_voltage_on_the_coil_at_rest(armed: Bench, until: Until, phase: Phase) -> None:
    armed.energise("a", 1.5, 30.0)
    until(lambda: (live := armed.state().live) is not None and abs(live.voltage - 1.5) < 0.05)
    assert armed.state().phase == "moving"
    armed.halt("a")
    phase(armed, "armed", 5.0)
    until(lambda: (live := armed.state().live) is not None and abs(live.voltage) < 0.05, 2.0)
    with pytest.raises(InputError, match=r"voltage = 9 V is not allowed; the coil takes 0 V to 4\.4 V"):
        armed.energise("a", 9.0, 1.0)
    with pytest.raises(InputError, match="at most 120 s"):
        armed.energise("a", 1.0, 1000.0)
