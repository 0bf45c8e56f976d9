"""The thread that owns the rig does its jobs in order, no exception ends it, and it may die with its process."""

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from tests.rig_time import HANG, RealTime, SimulatedTime

from dampyr.console.bench_thread import RigThread


def test_jobs_are_done_in_their_order_and_no_exception_ends_the_thread() -> None:
    done: list[object] = []
    names: list[str] = []
    looked, wait = threading.Event(), threading.Event()
    thread = RigThread(looked.set, lambda problem: done.append(str(problem)), lambda: done.append("left"))

    def fail() -> None:
        names.append(threading.current_thread().name)
        raise ZeroDivisionError("it failed")

    for job in (wait.wait, lambda: done.append(1), fail, lambda: done.append(2)):
        thread.jobs.put(job)  # type: ignore[arg-type]
    assert thread.wanted
    wait.set()
    assert looked.wait(HANG)  # while no job comes
    assert (done, names) == ([1, "it failed", 2], ["bench"])
    assert not thread.wanted
    thread.close()
    assert done == [1, "it failed", 2, "left"]


def test_a_thread_that_is_closed_begins_no_further_job_and_tells_how_it_left() -> None:
    done: list[object] = []
    begun, wait = threading.Event(), threading.Event()

    def work() -> None:
        begun.set()
        wait.wait()
        done.append("under way")

    def leave() -> None:
        raise OSError("the port is gone")

    thread = RigThread(lambda: None, lambda problem: done.append(str(problem)), leave)
    thread.jobs.put(work)
    thread.jobs.put(lambda: done.append("never"))
    assert begun.wait(HANG)
    thread.closing.set()
    assert thread.wanted
    wait.set()
    thread.close()
    assert done == ["under way", "the port is gone"]


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


@pytest.mark.endure
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
