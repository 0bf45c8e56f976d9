"""The bench without a web: commands, control, abort from any thread, and a rig that nobody looks at."""

from pathlib import Path

import numpy as np
import pytest
from tests.console.bench_runs import Phase, Until, outcome, position, reason, records_of
from tests.console.bench_runs import start as run
from tests.rig_time import RealTime
from tests.short_campaign import SHORT

from dampyr.campaigns import read_journal
from dampyr.console import bench_session
from dampyr.console.bench_session import Bench
from dampyr.errors import InputError, RigFault
from dampyr.records import read
from dampyr.rig import Rig

pytestmark = pytest.mark.endure


def test_connect_arm_home_jog_disarm(armed: Bench, bench_time: RealTime, until: Until, phase: Phase) -> None:
    assert [ring.state for ring in armed.state().rings] == ["watching", "watching", "off"]
    assert armed.state().live is not None
    for _ in range(10):
        armed.jog("a", 0.005)
        bench_time.sleep(0.05)
    armed.jog("a", 0.0)
    until(lambda: not armed.state().jogging)
    assert 0.001 < position(armed) < 0.006
    armed.disarm("a")
    phase(armed, "idle")
    state = armed.state()
    assert not state.armed
    assert [ring.state for ring in state.rings] == ["off", "off", "off"]  # none of them protects a rig without energy
    assert state.rings[0].words.startswith("idle, energy off; once armed it stops")
    assert state.rings[1].words.startswith("once armed it stops beyond 4500 N, ±37 mm")
    armed.disconnect("a")
    phase(armed, "disconnected")
    assert armed.state().rig is None


def test_homing_stops_when_another_page_takes_control(armed: Bench, until: Until, phase: Phase) -> None:
    armed.clients.join("b")
    armed.home("a")
    until(lambda: armed.state().rings[0].words.startswith("homing"))
    armed.clients.take("b")
    phase(armed, "armed", 2.0)
    assert "no longer holds control" in armed.state().note
    until(lambda: armed.state().rings[0].words.startswith("armed"), 2.0)


def test_a_table_is_homed_by_its_index(bench: Bench, phase: Phase) -> None:
    bench.connect("a")
    phase(bench, "idle")
    bench.arm("a")
    phase(bench, "armed")
    with pytest.raises(InputError, match="at most 2 mm/s; home the table to go faster"):
        bench.jog("a", 0.005)
    bench.home("a")
    phase(bench, "armed")
    assert bench.state().homed


def test_commands_are_refused_in_the_wrong_state_and_from_the_wrong_page(bench: Bench, until: Until) -> None:
    with pytest.raises(InputError, match="the bench is disconnected; for this it has to be idle"):
        bench.arm("a")
    with pytest.raises(InputError, match="the bench is disconnected"):
        run(bench)
    bench.clients.join("b")
    with pytest.raises(InputError, match="page 1 holds control"):
        bench.connect("b")
    with pytest.raises(InputError, match="is not known"):
        bench.connect("a", "no such rig")
    assert bench.state().phase == "disconnected"


def test_a_rig_that_cannot_be_opened_leaves_the_bench_disconnected(
    bench: Bench, bench_time: RealTime, until: Until, phase: Phase
) -> None:
    bench_time.faults = ("nonsense",)
    bench.connect("a")
    until(lambda: bench.state().fault)
    assert "nonsense" in bench.state().note
    assert bench.state().phase == "disconnected"
    bench_time.faults = ()
    bench.connect("a")
    phase(bench, "idle")


def test_a_rig_that_does_not_answer_at_first_is_closed(
    bench: Bench, bench_time: RealTime, until: Until, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed = []
    open_rig = bench_time.open

    def silent_rig(data: Path, name: str, simulate: bool) -> Rig:
        rig = open_rig(data, name, simulate)
        rig.on_close.append(lambda: closed.append(rig))
        monkeypatch.setattr(rig.uno, "heartbeat", refuse)
        return rig

    def refuse() -> None:
        raise RigFault("the Uno does not answer", "firmware")

    monkeypatch.setattr(bench, "_opener", silent_rig)
    bench.connect("a")
    until(lambda: bench.state().fault)
    assert bench.state().note == "the Uno does not answer"
    assert bench.state().phase == "disconnected"
    assert len(closed) == 1


def test_abort_while_armed_and_on_the_way_to_it(armed: Bench, until: Until, phase: Phase) -> None:
    armed.jog("a", 0.005)
    until(lambda: armed.state().jogging)
    armed.abort("page 2")
    phase(armed, "idle", 5.0)
    assert armed.state().note == "aborted: by page 2"
    until(lambda: armed.state().rings[0].state == "acted", 2.0)
    armed.arm("a")
    assert armed.state().note == ""
    armed.abort()
    phase(armed, "idle", 5.0)
    assert not armed.state().armed
    armed.arm("a")  # and it can be armed again
    phase(armed, "armed", 5.0)


def test_a_campaign_to_its_end_survives_its_page(armed: Bench, until: Until, phase: Phase) -> None:
    run(armed)
    phase(armed, "campaign")
    armed.clients.disconnect("a")
    until(lambda: (progress := armed.state().run) is not None and progress.cycles > 0.5)
    armed.clients.join("a")
    phase(armed, "idle")
    progress = armed.state().run
    assert progress is not None
    assert (progress.outcome, progress.done, progress.tests, progress.fraction) == ("complete", 2, 2, 1.0)
    assert progress.planned_cycles > 1.9
    assert progress.cycles == pytest.approx(progress.planned_cycles, abs=0.51)
    record = read(records_of(armed) / "01-sine-4mm-1Hz-0V.h5")
    assert np.ptp(record.displacement) == pytest.approx(0.008, rel=0.05)
    words = "checks a whole campaign before it moves; the last one, short: all of its 2 tests passed"
    assert (armed.state().rings[2].state, armed.state().rings[2].words) == ("off", words)


def test_a_page_that_vanishes_during_a_campaign_loses_control(armed: Bench, bench_time: RealTime, until: Until) -> None:
    armed.clients.join("b")
    run(armed)
    until(lambda: (progress := armed.state().run) is not None and progress.cycles > 0.3)
    bench_time.while_waiting = lambda: armed.clients.hear("b")
    until(lambda: armed.state().holder == "", 10.0)
    armed.clients.take("b")
    armed.stop("b")
    until(lambda: armed.state().phase == "idle")


def test_pause_resume_and_stop(armed: Bench, until: Until, phase: Phase) -> None:
    run(armed)
    armed.pause("a", True)
    until(lambda: (progress := armed.state().run) is not None and progress.phase == "paused")
    armed.pause("a", False)
    until(lambda: (progress := armed.state().run) is not None and progress.phase == "testing")
    armed.stop("a")
    phase(armed, "idle", 5.0)
    assert outcome(armed) == "stopped"
    run(armed)  # goes on
    phase(armed, "idle")
    assert outcome(armed) == "complete"


def test_a_campaign_is_aborted_and_its_record_says_so(armed: Bench, until: Until, phase: Phase) -> None:
    run(armed)
    until(lambda: (progress := armed.state().run) is not None and progress.phase == "testing")
    armed.abort()
    phase(armed, "idle", 5.0)
    assert outcome(armed) == "aborted"
    assert reason(armed) == "aborted: by the operator"
    assert read_journal(records_of(armed))[0][0].reason == "aborted: by the operator"


def test_abort_before_a_campaign_arms_lets_nothing_move(bench: Bench, phase: Phase) -> None:
    bench.connect("a")
    phase(bench, "idle")
    run(bench)
    bench.abort()
    phase(bench, "idle", 10.0)
    assert outcome(bench) == "aborted"
    folder = records_of(bench)
    assert not folder.is_dir() or not list(folder.glob("*.h5"))


def test_stop_acts_while_the_table_is_homed(bench: Bench, bench_time: RealTime, until: Until, phase: Phase) -> None:
    bench.connect("a")
    phase(bench, "idle")
    run(bench)
    until(lambda: (progress := bench.state().run) is not None and progress.phase == "homing")
    bench_time.sleep(0.1)
    bench.stop("a")
    phase(bench, "idle", 3.0)
    assert outcome(bench) == "stopped"


def test_a_campaign_that_the_rig_cannot_do_is_refused_before_it_arms(bench: Bench, phase: Phase) -> None:
    (bench.data / "campaigns" / "short.toml").write_text(SHORT.replace("4 mm", "30 mm"))
    bench.connect("a")
    phase(bench, "idle")
    with pytest.raises(InputError, match="lower the amplitude to"):
        run(bench)
    assert bench.state().phase == "idle"
    assert bench.state().rings[2].state == "acted"


@pytest.mark.parametrize("times", [1, pytest.param(2, marks=pytest.mark.prove)])
def test_the_steps_of_the_guide_twice_on_one_rig(
    bench: Bench, bench_time: RealTime, until: Until, phase: Phase, times: int
) -> None:
    """docs/how-to/bench.md: arm, home, jog, run a campaign; abort; and all of it again, wherever the table was left."""
    bench.connect("a")
    phase(bench, "idle")
    for k in range(times):
        bench.arm("a")
        phase(bench, "armed")
        bench.home("a")
        phase(bench, "armed")
        assert bench.state().homed
        for _ in range(12):
            bench.jog("a", 0.008)
            bench_time.sleep(0.05)
        bench.jog("a", 0.0)
        until(lambda: not bench.state().jogging)
        assert position(bench) > 0.003
        run(bench, f"run{k}")
        phase(bench, "campaign")
        phase(bench, "idle")
        assert outcome(bench) == "complete", reason(bench)
        run(bench, f"run{k}-aborted")
        until(lambda: (progress := bench.state().run) is not None and progress.cycles > 0.5)
        bench.abort()
        phase(bench, "idle", 5.0)
        assert outcome(bench) == "aborted"
        bench.arm("a")
        phase(bench, "armed")
        bench.jog("a", -0.005)
        until(lambda: bench.state().jogging)
        bench.jog("a", 0.0)
        bench.disarm("a")
        phase(bench, "idle")
        assert not bench.state().fault, bench.state().note
        run(bench, f"run{k}-aborted")  # goes on
        phase(bench, "idle")
        assert outcome(bench) == "complete", reason(bench)


def test_an_armed_rig_that_nobody_looks_at_is_disarmed(
    armed: Bench, monkeypatch: pytest.MonkeyPatch, phase: Phase
) -> None:
    monkeypatch.setattr(bench_session, "GRACE", 0.3)
    armed.clients.disconnect("a")
    phase(armed, "idle", 5.0)
    assert "no page is open" in armed.state().note


def test_a_page_loaded_anew_finds_the_rig_armed(armed: Bench, bench_time: RealTime) -> None:
    armed.clients.disconnect("a")
    bench_time.sleep(0.2)
    armed.clients.join("a")
    bench_time.sleep(0.2)
    assert armed.state().phase == "armed"
    armed.disarm("a")


def test_the_interlock_is_seen(bench: Bench, bench_time: RealTime, until: Until, phase: Phase) -> None:
    bench_time.faults = ("broken-cell@1s",)
    bench.connect("a")
    phase(bench, "idle")
    bench.arm("a")
    until(lambda: bench.state().rings[1].state == "acted", 10.0)
    phase(bench, "idle", 5.0)
    assert "interlock" in bench.state().note
    assert bench.state().fault
