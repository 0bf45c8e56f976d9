"""The bench without a web: a rig read by a thread, commands, control, abort from any thread, a server that dies."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.rig_time import HANG, RealTime, SimulatedTime

from dampyr.campaigns import read_journal
from dampyr.console import bench_thread
from dampyr.console.bench_session import Bench
from dampyr.errors import InputError
from dampyr.records import read

pytestmark = pytest.mark.endure

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


@pytest.fixture
def bench(tmp_path: Path, bench_time: RealTime) -> Iterator[Bench]:
    """A bench whose page "a" holds control, nothing connected; its pages are heard of while a test waits."""
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
def phase(until: Until) -> Callable[..., None]:
    """``phase(bench, name, seconds)``: wait for a phase of the bench."""
    return lambda bench, name, seconds=30.0: until(lambda: bench.state().phase == name, seconds)


@pytest.fixture
def armed(bench: Bench, phase: Phase) -> Bench:
    """A bench that is armed and homed."""
    bench.connect("a")
    phase(bench, "idle")
    bench.arm("a")
    phase(bench, "armed")
    bench.home("a", here=True)
    phase(bench, "armed")
    assert bench.state().homed
    return bench


def run(bench: Bench, folder: str = "run") -> None:
    bench.start("a", "short", bench.data / "short.toml", bench.data / folder)


def outcome(bench: Bench) -> str:
    progress = bench.state().run
    return progress.outcome if progress else ""


def reason(bench: Bench) -> str:
    progress = bench.state().run
    return progress.reason if progress else ""


def position(bench: Bench) -> float:
    live = bench.state().live
    assert live is not None
    return live.position


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
    assert state.rings[0].words == "idle, energy off"
    armed.disconnect("a")
    phase(armed, "disconnected")
    assert armed.state().rig is None


def test_a_jog_that_is_not_asked_for_again_stops(armed: Bench, until: Until) -> None:
    armed.jog("a", 0.005)
    until(lambda: armed.state().jogging)
    until(lambda: not armed.state().jogging, 2.0)
    assert position(armed) < 0.005 * 1.5


def test_a_jog_stops_with_its_page(armed: Bench, until: Until) -> None:
    armed.clients.join("b")
    armed.jog("a", 0.005)
    until(lambda: armed.state().jogging)
    armed.clients.disconnect("a")
    until(lambda: not armed.state().jogging, 2.0)
    assert armed.state().holder == ""
    assert armed.state().phase == "armed"  # "b" still looks on


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


def test_an_armed_rig_that_nobody_looks_at_is_disarmed(
    armed: Bench, monkeypatch: pytest.MonkeyPatch, phase: Phase
) -> None:
    monkeypatch.setattr(bench_thread, "GRACE", 0.3)
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


def test_commands_are_refused_in_the_wrong_state_and_from_the_wrong_page(bench: Bench, until: Until) -> None:
    with pytest.raises(InputError, match="the bench is disconnected; for this it has to be idle"):
        bench.arm("a")
    with pytest.raises(InputError, match="the bench is disconnected"):
        run(bench)
    bench.clients.join("b")
    with pytest.raises(InputError, match="page 1 holds control"):
        bench.connect("b")
    bench.connect("a", "no such rig")
    until(lambda: bench.state().fault)
    assert "is not known" in bench.state().note
    assert bench.state().phase == "disconnected"


def test_the_ends_of_the_stroke_are_not_jogged_into(armed: Bench, bench_time: RealTime, until: Until) -> None:
    def on() -> None:
        while True:
            armed.jog("a", 0.010)
            bench_time.sleep(0.05)

    with pytest.raises(InputError, match="before the end of its stroke; jog the other way"):
        on()
    until(lambda: not armed.state().jogging)
    assert 0.030 < position(armed) < 0.037
    assert armed.state().phase == "armed"


def test_abort_while_armed_and_on_the_way_to_it(armed: Bench, until: Until, phase: Phase) -> None:
    armed.jog("a", 0.005)
    until(lambda: armed.state().jogging)
    armed.abort("page 2")
    table_rests = armed.state().rings[0]
    phase(armed, "idle", 5.0)
    assert armed.state().note == "aborted: by page 2"
    assert table_rests.state in ("watching", "acted")
    until(lambda: armed.state().rings[0].state == "acted", 2.0)
    armed.arm("a")
    assert armed.state().note == ""
    armed.abort()
    phase(armed, "idle", 5.0)
    assert not armed.state().armed
    armed.arm("a")  # and it can be armed again
    phase(armed, "armed", 5.0)


def test_the_load_cell_is_zeroed(armed: Bench, until: Until, phase: Phase) -> None:
    armed.zero("a")
    phase(armed, "armed", 5.0)
    rig = armed.rig
    assert rig is not None
    assert rig.calibration is not None
    assert abs(rig.calibration.zero) > 0.01  # the simulated damper pushes
    assert rig.calibration.how.endswith(", zeroed at rest")
    until(lambda: (live := armed.state().live) is not None and abs(live.force) < 5.0, 2.0)


def test_the_guided_steps_of_a_calibration(bench: Bench, until: Until, phase: Phase) -> None:
    bench.connect("a")
    phase(bench, "idle")
    with pytest.raises(InputError, match="no calibration is under way"):
        bench.calibrate_step("a", "unloaded")
    bench.calibrate("a")
    bench.calibrate_step("a", "loaded", "20 kg")
    until(lambda: bench.state().fault)
    assert "read it first, without load" in bench.state().note
    bench.calibrate_step("a", "unloaded")
    until(lambda: (guided := bench.state().guided) is not None and guided.zeroed)
    phase(bench, "idle")
    bench.calibrate_step("a", "loaded", "20 kg")
    until(lambda: "mV only" in bench.state().note)  # nothing hangs on the cell
    phase(bench, "idle")
    bench.calibrate_end("a", keep=True)
    state = bench.state()
    assert state.guided is None
    assert state.rig is not None
    assert state.rig.calibrated == "zero read, scale as before"
    assert abs(state.rig.zero) > 0.01


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
    record = read(armed.data / "run" / "01-sine-4mm-1Hz-0V.h5")
    assert np.ptp(record.displacement) == pytest.approx(0.008, rel=0.05)
    assert armed.state().rings[2].words == "short: all of its 2 tests passed"


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
    assert read_journal(armed.data / "run")[0][0].reason == "aborted: by the operator"


def test_abort_before_a_campaign_arms_lets_nothing_move(bench: Bench, phase: Phase) -> None:
    bench.connect("a")
    phase(bench, "idle")
    run(bench)
    bench.abort()
    phase(bench, "idle", 10.0)
    assert outcome(bench) == "aborted"
    folder = bench.data / "run"
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
    (bench.data / "short.toml").write_text(CAMPAIGN.replace("4 mm", "30 mm"))
    bench.connect("a")
    phase(bench, "idle")
    with pytest.raises(InputError, match="lower the amplitude to"):
        run(bench)
    assert bench.state().phase == "idle"
    assert bench.state().rings[2].state == "acted"


def test_the_interlock_is_seen(bench: Bench, bench_time: RealTime, until: Until, phase: Phase) -> None:
    bench_time.faults = ("broken-cell@1s",)
    bench.connect("a")
    phase(bench, "idle")
    bench.arm("a")
    until(lambda: bench.state().rings[1].state == "acted", 10.0)
    phase(bench, "idle", 5.0)
    assert "interlock" in bench.state().note
    assert bench.state().fault


def test_the_steps_of_the_guide_twice_on_one_rig(
    bench: Bench, bench_time: RealTime, until: Until, phase: Phase
) -> None:
    """docs/how-to/bench.md: arm, home, jog, run a campaign; abort; and all of it again, wherever the table was left."""
    bench.connect("a")
    phase(bench, "idle")
    for k in range(2):
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


DYING = """
import sys, time
from contextlib import suppress
from pathlib import Path
from dampyr.console.bench_session import Bench
from dampyr.errors import InputError
from dampyr.rig import simulated
from tests.rig.wires.process import over_wires
real = sys.argv[2] == "real"
connect = simulated if real else over_wires
bench = Bench(Path("."), lambda *_: connect(black_box=sys.argv[1], **({"real_time": True} if real else {})))
bench.clients.join("a")

def wait(phase):
    while bench.state().phase != phase:
        bench.clients.hear("a")
        time.sleep(0.01)

bench.connect("a")
wait("idle")
bench.arm("a")
wait("armed")
bench.home("a", here=True)
while not bench.state().homed:
    wait("armed")
while True:
    bench.clients.hear("a")
    with suppress(InputError):  # the end of the stroke
        bench.jog("a", 0.005)
    time.sleep(0.01)
    if bench.state().jogging: print("jogs", flush=True)
"""


def test_when_the_server_dies_the_rig_comes_to_rest(tmp_path: Path, bench_time: RealTime) -> None:
    box = tmp_path / "box.jsonl"
    kind = "lockstep" if isinstance(bench_time, SimulatedTime) else "real"
    command = [sys.executable, "-c", DYING, str(box), kind]
    path = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    server = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True, env=path)
    assert server.stdout is not None
    assert server.stdout.readline() == "jogs\n"
    os.kill(server.pid, signal.SIGKILL)
    server.wait()
    server.stdout.close()
    if kind == "real":  # the process that reads it, and simulates it, stops it in order
        RealTime().until(lambda: box.read_text().count('"enable low"') == box.read_text().count('"enable high"'), HANG)
        RealTime().until(
            lambda: json.loads(box.read_text().splitlines()[-1])["event"] in ("at rest", "coil dead"), HANG
        )
        return
    RealTime().until(lambda: '"ends"' in box.read_text(), HANG)
    events = [json.loads(line)["event"] for line in box.read_text().splitlines()]
    closed = events.index("serial closed")
    assert any("HEARTBEAT" in event for event in events[closed:]), events[closed:]
