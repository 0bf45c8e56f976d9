"""Work at the bench besides a campaign: motions by hand, alarms, peak hold, a queue, skip and repeat, a reference."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient
from tests.rig_time import RealTime

from dampyr.campaigns import read_journal
from dampyr.console import app
from dampyr.console.bench_alarms import FILE as LIMITS
from dampyr.console.bench_alarms import AlarmLimit, Alarms
from dampyr.console.bench_events import FILE as EVENTS
from dampyr.console.bench_reference import CycleJudge, of_record
from dampyr.console.bench_session import Bench, RunAbout
from dampyr.console.run_reference import REPORT, RunReference
from dampyr.errors import InputError
from dampyr.records import Record, read
from dampyr.rig.interlock import Samples

Until = Callable[..., None]
Phase = Callable[..., None]
CAMPAIGN = """
name = "short"
rest_between = "0.2 s"
check_amplitude = 0.0
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "1 Hz"
voltage = ["0 V", "0.8712 V"]
cycles = 2
rest_before = "0.2 s"
"""
FIRST, SECOND = "01-sine-4mm-1Hz-0V", "02-sine-4mm-1Hz-0.8712V"


@pytest.fixture
def bench(tmp_path: Path, bench_time: RealTime) -> Iterator[Bench]:
    """A bench whose page "a" holds control, nothing connected."""
    (tmp_path / "short.toml").write_text(CAMPAIGN)
    made = Bench(tmp_path, bench_time.open, bench_time)
    made.clients.join("a")
    bench_time.while_waiting = lambda: (made.clients.hear("a"), made.clients.hear("b"))
    yield made
    with bench_time.passing():
        made.close()


@pytest.fixture
def until(bench_time: RealTime) -> Until:
    """``until(condition, seconds)``: wait for something; fail where it does not come."""
    return bench_time.until


@pytest.fixture
def phase(until: Until) -> Phase:
    """``phase(bench, name, seconds)``: wait for a phase of the bench."""
    return lambda bench, name, seconds=30.0: until(lambda: bench.state().phase == name, seconds)


@pytest.fixture
def idle(bench: Bench, phase: Phase) -> Bench:
    """A bench with a rig that is not armed."""
    bench.connect("a")
    phase(bench, "idle")
    return bench


@pytest.fixture
def armed(idle: Bench, phase: Phase) -> Bench:
    """A bench that is armed and homed."""
    idle.arm("a")
    phase(idle, "armed")
    idle.home("a", here=True)
    phase(idle, "armed")
    return idle


def start(bench: Bench, folder: str = "run", **more: object) -> None:
    bench.start("a", "short", bench.data / "short.toml", bench.data / folder, **more)  # type: ignore[arg-type]


def states(folder: Path) -> dict[str, str]:
    return {entry.name: entry.state for entry in read_journal(folder)[0]}


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


def test_an_alarm_is_latched_until_it_is_acknowledged(armed: Bench, until: Until, phase: Phase) -> None:
    armed.set_alarm_limit("a", AlarmLimit("position", -0.004, 0.004))
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
        armed.set_alarm_limit("a", AlarmLimit("position", 0.005, 0.004))
    armed.set_alarm_limit("a", AlarmLimit("position"))
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
    assert any("load cell signal" in event.what for event in bench.events)


def test_the_log_says_who_did_what_and_is_kept_with_the_run(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed, about=RunAbout("A. Operator", "damper 7", "after repair"))
    until(lambda: (run := armed.state().run) is not None and run.cycles > 0.3)
    armed.clients.join("b")
    armed.take_control("b")
    armed.abort("page 2")
    phase(armed, "idle", 5.0)
    started = "A. Operator, page 1"
    said = [f"{event.who}: {event.what}" for event in reversed(armed.events)]
    for words in (
        "page 1: connects the original rig, simulated", "page 1: arms", "rig: armed", f"{started}: starts short into run",
        "page 2: took control from page 1", "page 2: aborts",
    ):  # fmt: skip
        assert words in said, (words, said)
    energy = [words for words in said if words.startswith(("rig: armed", "rig: disarmed"))]
    assert energy == [
        "rig: armed", "rig: disarmed", f"rig: armed for the campaign short, started by {started}", "rig: disarmed",
    ]  # fmt: skip
    lines = [json.loads(line) for line in (armed.data / "run" / EVENTS).read_text().splitlines()]
    assert lines[0]["what"] == "starts short into run"
    assert [line["what"] for line in lines if line["who"] == "page 2"] == ["took control from page 1", "aborts"]
    assert Bench(armed.data).events == armed.events  # the next session shows them
    partial = next((armed.data / "run").glob("*.h5"))
    assert partial.is_file()


@pytest.mark.parametrize("by_hand", [False, True])
def test_the_log_says_when_energy_enters_and_leaves_in_a_campaign(
    idle: Bench, phase: Phase, until: Until, by_hand: bool
) -> None:
    """As evidence after an accident: from the begin of a campaign to its end, whether the rig was armed before or not."""
    if by_hand:
        idle.arm("a")
        phase(idle, "armed")
        idle.home("a", here=True)
        phase(idle, "armed")
    start(idle, about=RunAbout("A. Operator"))
    phase(idle, "campaign")
    phase(idle, "idle", 60.0)
    lines = [json.loads(line) for line in (idle.data / "run" / EVENTS).read_text().splitlines()]
    said = [line["what"] for line in lines]
    first = said.index("armed for the campaign short, started by A. Operator, page 1")
    assert said[:first] == (["starts short into run"] + by_hand * ["disarmed"])
    assert said[-2:] == ["disarmed", "campaign complete"]
    assert not {"armed", "disarmed"} & set(said[first + 1 : -2])


def test_an_abort_without_a_page_names_its_address(tmp_path: Path) -> None:
    with TestClient(app(tmp_path), "http://localhost", client=("192.0.2.7", 4711)) as asking:
        assert asking.post("/api/bench/abort", json={}).status_code == 200
        event = asking.get("/api/bench/events").json()[0]
    assert (event["who"], event["what"]) == ("a request from 192.0.2.7", "aborts")


def test_who_and_what_are_in_the_records(armed: Bench, phase: Phase) -> None:
    start(armed, about=RunAbout("A. Operator", "damper-7", "after repair"))
    phase(armed, "campaign")
    run = armed.state().run
    assert run is not None
    assert (run.operator, run.specimen) == ("A. Operator", "damper-7")
    phase(armed, "idle")
    record = read(armed.data / "run" / f"{FIRST}.h5")
    assert record.specimen == "damper-7"
    assert record.provenance["operator"] == "A. Operator"


def test_a_complete_folder_is_refused_before_anything_moves(armed: Bench, phase: Phase) -> None:
    start(armed)
    phase(armed, "campaign")
    phase(armed, "idle")
    with pytest.raises(InputError, match="all 2 tests are recorded there"):
        start(armed)
    (armed.data / "short.toml").write_text(CAMPAIGN.replace("4 mm", "3 mm"))
    with pytest.raises(InputError, match="holds the campaign 'short', which is another one"):
        start(armed)
    assert armed.state().phase == "idle"


def test_a_queue_goes_on_only_after_what_was_complete(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed, "one")
    for name in ("two", "three"):
        armed.enqueue("a", "short", armed.data / "short.toml", armed.data / name, RunAbout("A. Operator"))
    with pytest.raises(InputError, match="waits in the queue already"):
        armed.enqueue("a", "short", armed.data / "short.toml", armed.data / "two", RunAbout())
    assert [queued.folder for queued in armed.state().queue] == ["two", "three"]
    until(lambda: (run := armed.state().run) is not None and run.folder == "two" and run.cycles > 0.3, 60.0)
    assert set(states(armed.data / "one").values()) == {"complete"}
    armed.abort()
    phase(armed, "idle", 5.0)
    assert [queued.folder for queued in armed.state().queue] == ["three"]  # it waits: what came before was aborted
    armed.dequeue("a", armed.state().queue[0].number)
    assert armed.state().queue == ()


def test_a_test_is_skipped_and_one_repeated(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed)
    until(lambda: (run := armed.state().run) is not None and run.cycles > 0.3)
    armed.skip("a", FIRST)
    until(lambda: (run := armed.state().run) is not None and run.test == SECOND and run.cycles > 0.3, 60.0)
    armed.repeat("a", SECOND)
    phase(armed, "idle", 60.0)
    run = armed.state().run
    assert run is not None
    assert run.outcome == "stopped"
    assert f"skipped by the operator: {FIRST}" in run.reason
    assert states(armed.data / "run") == {FIRST: "stopped", SECOND: "complete"}
    assert sorted(path.name for path in (armed.data / "run").glob("02*.h5")) == [f"{SECOND}.h5", f"{SECOND}.try2.h5"]
    start(armed)  # goes on with what was skipped
    phase(armed, "campaign")
    phase(armed, "idle")
    assert states(armed.data / "run") == {FIRST: "complete", SECOND: "complete"}


@pytest.mark.prove
def test_cycles_are_compared_with_a_reference_and_a_report_is_written(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed, "one")
    phase(armed, "campaign")
    phase(armed, "idle")
    start(armed, "two", reference=RunReference(armed.data / "one", 0.15))
    until(lambda: (comparison := armed.state().comparison) is not None and comparison.passed > 0, 60.0)
    assert armed.reference_loop is not None
    assert np.ptp(armed.reference_loop.x) == pytest.approx(8.0, rel=0.05)
    phase(armed, "idle")
    comparison = armed.state().comparison
    assert comparison is not None
    assert comparison.failed == 0
    until(lambda: (run := armed.state().run) is not None and run.report_state != "writing", 60.0)
    run = armed.state().run
    assert run is not None
    assert (run.report, run.report_state) == (REPORT, "")
    assert "<html" in (armed.data / "two" / REPORT).read_text()


@pytest.mark.parametrize(("factor", "passes"), [(1.0, True), (1.1, True), (1.25, False), (0.8, False)])
@pytest.mark.parametrize("centre", [0.0, 0.005])
def test_a_cycle_passes_within_the_tolerance(factor: float, passes: bool, centre: float) -> None:
    time = np.arange(0.0, 10.0, 1e-3)
    grow = np.clip(time / 2, 0, 1) * np.clip((10 - time) / 2, 0, 1)
    x = 0.01 * grow * np.sin(2 * np.pi * time)
    force = 500.0 * np.tanh(np.gradient(x, time) / 1e-3) + 2000.0 * np.gradient(x, time)
    reference = of_record(Record(time, x + centre, force, voltage=0.0), "a")
    assert reference.measures.energy == pytest.approx(4 * 500 * 0.01 + 2000 * np.pi * 0.01**2 * 2 * np.pi, rel=0.02)
    judge = CycleJudge(reference, 0.15)
    judged = []
    for k in range(0, len(time), 40):
        part = slice(k, k + 40)
        none = np.zeros((1, 40))
        samples = Samples(
            k, time[part], x[part] + centre, factor * force[part], None, none, none[0].astype(int), none[0], None
        )  # type: ignore[arg-type]
        judged += judge.take(samples)
    assert [cycle.number for cycle in judged] == [1, 2, 3, 4, 5, 6]
    assert all(cycle.passed is passes for cycle in judged)
    assert judged[2].energy == pytest.approx(factor - 1.0, abs=1e-3)
