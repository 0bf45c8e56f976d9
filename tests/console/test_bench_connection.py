"""The rig that is connected is read before it is armed, and after."""

from tests.console.bench_runs import Phase, Until

from dampyr.console.bench_session import Bench


def test_a_disarmed_rig_is_read_before_arming_and_after_an_abort(idle: Bench, until: Until, phase: Phase) -> None:
    until(lambda: idle.state().live is not None)
    live, age = idle.state().live, idle.state().live_age
    assert live is not None
    assert live.voltage == 0.0
    assert abs(live.force) > 10.0  # the simulated damper pushes
    assert age is not None
    assert age < 0.5
    bins = idle.strips.count if idle.strips else 0
    until(lambda: idle.strips is not None and idle.strips.count > bins + 20)
    idle.arm("a")
    phase(idle, "armed")
    idle.abort()
    phase(idle, "idle", 5.0)
    until(lambda: (now := idle.state()).live is not None and now.live.voltage == 0.0 and (now.live_age or 0.0) < 0.5)


def test_homed_positions_are_read_while_disarmed(armed: Bench, until: Until, phase: Phase) -> None:
    armed.go("a", 0.005)
    phase(armed, "moving")
    phase(armed, "armed")
    armed.disarm("a")
    phase(armed, "idle")
    until(
        lambda: (
            (live := armed.state().live) is not None and abs(live.position - 0.005) < 3e-4 and not armed.state().armed
        )
    )
