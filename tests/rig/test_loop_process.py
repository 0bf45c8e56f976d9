"""A rig in real time is read by a process of its own: nothing that its host does, or suffers, stops it or leaves it alone."""

import ctypes
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.process_functions import alive
from tests.rig.served_loop import Served, reader_of, stroke
from tests.rig.wires.process import Process
from tests.rig_time import SimulatedTime

from dampyr.errors import FileError, InputError, RigFault
from dampyr.rig import Rig, RigSettings, connect, loop_process, simulated
from dampyr.rig.firmware.protocol import State
from dampyr.rig.loop_process import LoopProcess, RemoteLoop
from dampyr.rig.loop_server import as_sent
from dampyr.rig.uno_clock import TOLERANCE

ROOT = Path(__file__).resolve().parents[2]
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


def test_errors_pass_from_one_process_to_the_other() -> None:
    fault = RigFault("the interlock stopped the rig: force 5000 N", "interlock")
    fault.add_note("the board does not answer")
    same = sent(fault)
    assert isinstance(same, RigFault)
    assert (str(same), same.ring, same.__notes__) == (str(fault), "interlock", ["the board does not answer"])
    assert type(sent(InputError("17 set points"))) is InputError
    assert str(sent(FileError("rig.toml", "is not there"))) == "rig.toml: is not there"
    other = sent(ZeroDivisionError("division by zero"))
    assert isinstance(other, RigFault)
    assert str(other) == "the process that reads the rig failed: ZeroDivisionError: division by zero"

    class BlownFuse(RigFault):  # of a driver that this process has not loaded
        pass

    assert type(sent(BlownFuse("the fuse is blown"))) is RigFault


def sent(problem: BaseException) -> InputError | RigFault:
    arrived: InputError | RigFault = pickle.loads(pickle.dumps(as_sent(problem)))
    return arrived


def test_a_process_that_ends_at_once_is_no_endless_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop_process, "serve_rig", os.abort)  # takes no arguments, so that it fails
    with pytest.raises(RigFault, match="the process that is to read the rig did not start; what it printed is above"):
        LoopProcess(RigSettings())


def test_a_table_moves_and_is_recorded_as_in_one_process(served: Served) -> None:
    rig, here = served.rig, SimulatedTime()
    drives = []
    with here.connect(RigSettings()) as local, here.passing():
        for each in (local, rig):
            with each.armed() as table:
                table.home(here=True)
                table.go(0.004)
                played = list(table.play(stroke(table.position)))
            samples = np.concatenate([samples.displacement[selection] for samples, selection in played])
            firsts = [block.first for block, _ in played]
            assert np.all(np.diff(firsts) == played[0][0].n)
            drives.append(samples)
    assert drives[0].size == drives[1].size == 1991
    np.testing.assert_allclose(drives[1], drives[0], atol=2e-4)


def test_it_is_armed_again_and_again_wherever_it_stands(served: Served) -> None:
    ratios = []
    for place in (0.012, -0.009, 0.003):
        with served.rig.armed() as table:
            if not table.homed:
                table.home(here=True)
            table.go(place)
            assert table.position == pytest.approx(place, abs=1e-4)
            ratios.append(table.loop.clock_ratio)
        assert served.rig.uno.heartbeat().state is State.IDLE
    # What the other process knows of the Uno's clock stays known.
    assert ratios[-1].uncertainty < ratios[0].uncertainty < TOLERANCE
    assert ratios[-1].value == pytest.approx(1.0 - 1500e-6, abs=4.0 * ratios[-1].uncertainty)


def test_calibration_and_temperature_are_those_of_both_ends(served: Served) -> None:
    rig = served.rig
    rig.warmth.temperature = 40.0
    with rig.armed() as table:
        volts = table.zero_force(0.5)
        assert rig.calibration is not None
        assert rig.calibration.zero == volts
        table.rest(0.2)
        assert table.loop.calibration.zero == volts
        assert 39.0 < table.temperature < 40.0
        assert rig.warmth.temperature == table.temperature


def test_an_abort_of_any_thread_ends_what_is_waited_for(served: Served) -> None:
    with pytest.raises(RigFault, match="aborted: by a friend") as ended:
        aborted_in_motion(served.rig)
    assert ended.value.ring == "operator"
    assert served.rig.uno.heartbeat().state is State.FAULT


def aborted_in_motion(rig: Rig) -> None:
    with rig.armed() as table:
        table.home(here=True)
        table.check = lambda: table.abort("by a friend") if table.loop.status.speed else None
        table.go(0.02)


@pytest.mark.parametrize("request_of", ["arm", "home", "jog"])
def test_a_refusal_that_is_here_before_the_reason_is_told_as_the_reason(
    served: Served, monkeypatch: pytest.MonkeyPatch, request_of: str
) -> None:
    """The loop there stops the rig, and what it says of that has not come here yet when the Uno refuses the next request."""
    begin = RemoteLoop.begin

    def stop_there() -> None:
        monkeypatch.setattr(served.server, "blocks", SimpleNamespace(send=lambda _: None))
        assert served.server.loop is not None
        served.server.loop.halt(RigFault("the interlock stopped the rig: force 5000 N", "interlock"))

    def stopped_at_once(loop: RemoteLoop) -> None:
        begin(loop)
        stop_there()

    def requested() -> None:
        with served.rig.armed() as table:
            stop_there()
            if request_of == "home":
                table.home(here=True)
            table.jog(0.001)

    if request_of == "arm":
        monkeypatch.setattr(RemoteLoop, "begin", stopped_at_once)
    with pytest.raises(RigFault, match="the interlock stopped the rig: force 5000 N") as ended:
        requested()
    assert ended.value.ring == "interlock"


@POSIX
@pytest.mark.by_hand  # the wall clock's time
def test_a_host_that_is_held_up_loses_no_sample_and_stops_no_rig(rig: Rig) -> None:
    """Nothing else of the host runs for 0.7 s, as while a file is made on a slow disk: the watchdog allows 0.15 s."""
    interpreter = ctypes.PyDLL(None)
    seen: list[int] = []
    rig.watchers.append(lambda samples: seen.append(samples.first))
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        blocks = []
        for k, (samples, selection) in enumerate(table.play(stroke(table.position))):
            blocks.append((samples, selection))
            if k in (10, 35):
                interpreter.usleep(700_000)
        firsts = np.array([samples.first for samples, _ in blocks])
        assert np.all(np.diff(firsts) == blocks[0][0].n)
        assert sum(selection.stop - selection.start for _, selection in blocks) == 1991
        x = np.concatenate([samples.displacement[selection] for samples, selection in blocks])
        assert np.ptp(x) == pytest.approx(0.004, rel=0.1)
        assert table.loop.stopped is None
    assert rig.uno.heartbeat().state is State.IDLE
    assert set(firsts) <= set(seen)


@pytest.fixture
def rig() -> Iterator[Rig]:
    with simulated(real_time=True) as opened:
        yield opened


def stroke_until_killed(rig: Rig) -> None:
    with rig.armed() as table:
        table.home(here=True)
        threading.Timer(0.5, lambda: os.kill(reader_of(rig), signal.SIGKILL)).start()
        for _ in table.play(stroke(table.position, 20.0)):
            pass


@POSIX
@pytest.mark.by_hand
def test_a_rig_whose_reader_is_killed_says_so_and_is_stopped_by_the_uno(tmp_path: Path) -> None:
    box = tmp_path / "events"
    there = Process(RigSettings(), real_time=True, black_box=box)
    rig = connect(replace(RigSettings(), wires=replace(RigSettings().wires, **there.wires)))
    with pytest.raises(RigFault, match="the process that reads the rig has ended; the Uno stops the table"):
        stroke_until_killed(rig)
    with pytest.raises(RigFault, match="has ended"):
        rig.uno.heartbeat()
    rig.close()
    there.close()
    events = [json.loads(line)["event"] for line in box.read_text().splitlines()]
    assert events.index("coil dead") > 0
    assert "at rest" in events


HOST = """
import signal, sys, numpy as np
from dampyr.rig import Drive, simulated
signal.signal(signal.SIGINT, signal.default_int_handler)  # it is ignored below a shell's background job
t = np.arange(0.0, 20.0, 0.01)
rig = simulated(real_time=True, black_box=sys.argv[1])
with rig, rig.armed() as table:
    table.home(here=True)
    print(rig.uno._link.pid, flush=True)
    for _ in table.play(Drive(0.01, table.position + 0.002 * (1.0 - np.cos(2.0 * np.pi * t)), np.full(t.size, 1.0))):
        pass
"""


@POSIX
@pytest.mark.by_hand
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_host_that_is_killed_or_interrupted_leaves_no_reader_and_a_rig_at_rest(how: int, tmp_path: Path) -> None:
    box = tmp_path / "events"
    host = subprocess.Popen(
        [sys.executable, "-c", HOST, str(box)],
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert host.stdout is not None
    reader = int(host.stdout.readline())
    while '"moving"' not in box.read_text():  # on a busy machine it begins late
        time.sleep(0.05)
    before = len(box.read_text().splitlines())
    host.send_signal(how)
    host.communicate(timeout=20.0)
    for _ in range(200):
        if not alive(reader):
            break
        time.sleep(0.05)
    assert not alive(reader)
    events = [json.loads(line) for line in box.read_text().splitlines()[before:]]
    times = {each["event"]: each["time"] for each in reversed(events)}
    # the coil's current decays for 30 ms, which the simulation may not live to see
    assert times.get("coil dead", times["enable low"]) - events[0]["time"] < 0.3
    assert times["enable low"] - events[0]["time"] < 0.3
    assert times["at rest"] - events[0]["time"] < 0.3
    assert "firmware fault HEARTBEAT" not in times  # it was stopped in order, not by its watchdog
