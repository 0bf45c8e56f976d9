"""The thread that reads the rig: it disarms a rig that nobody looks at, sees the interlock, and may die."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.console.bench_runs import Phase, Until
from tests.rig_time import HANG, RealTime, SimulatedTime

from dampyr.console import bench_thread
from dampyr.console.bench_session import Bench

pytestmark = pytest.mark.endure


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


def test_the_interlock_is_seen(bench: Bench, bench_time: RealTime, until: Until, phase: Phase) -> None:
    bench_time.faults = ("broken-cell@1s",)
    bench.connect("a")
    phase(bench, "idle")
    bench.arm("a")
    until(lambda: bench.state().rings[1].state == "acted", 10.0)
    phase(bench, "idle", 5.0)
    assert "interlock" in bench.state().note
    assert bench.state().fault


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


@pytest.mark.prove  # a process of its own; tests/rig/wires ends hosts in every run
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
