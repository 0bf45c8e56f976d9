"""The clock of a simulated rig in real time: it waits for a host, and for its own process, on a busy machine."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from dampyr import records
from dampyr.campaigns import perform, read_journal
from dampyr.errors import RigFault
from dampyr.rig import Drive, Rig, RigSettings, simulated
from dampyr.rig.simulation import clock as clock_module
from dampyr.rig.simulation.clock import Clock, EventLog
from dampyr.rig.simulation.shared_clock import MAX_HOLD, SharedClock
from dampyr.rig.simulation.simulator import Simulator

BLOCK = RigSettings().board.block


class Wall:
    """A wall clock that goes by hand."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def wall(monkeypatch: pytest.MonkeyPatch) -> Wall:
    made = Wall()
    monkeypatch.setattr(clock_module, "time", made)
    return made


@pytest.fixture
def clock(wall: Wall, tmp_path: Path) -> Clock:
    made = Clock(Simulator(RigSettings()), EventLog(None), real_time=True, shared=SharedClock(tmp_path / "clock"))
    made.client_connected()
    made.rig.start(RigSettings().board.rate)
    return made


def steps(clock: Clock, wall: Wall, seconds: float, every: float = 0.01) -> None:
    for _ in range(round(seconds / every)):
        wall.now += every
        with clock.lock:
            clock._step()


def host_reads(clock: Clock, wall: Wall) -> float:
    """A host has read all that there was; the rig's time."""
    steps(clock, wall, BLOCK)
    with clock.locked():
        clock.read(clock.rig.waiting, 1.0)
    return clock.rig.time


def test_a_host_that_keeps_up_holds_nothing_back(clock: Clock, wall: Wall) -> None:
    for _ in range(50):
        host_reads(clock, wall)
    assert clock.held == 0.0
    assert clock.rig.time == pytest.approx(50 * BLOCK)


def test_a_late_host_is_waited_for_two_blocks_ahead(clock: Clock, wall: Wall) -> None:
    then = host_reads(clock, wall)
    steps(clock, wall, 0.5)
    assert clock.rig.time - then == pytest.approx(2 * BLOCK)
    assert clock.held == pytest.approx(0.5 - 2 * BLOCK)
    assert clock.shared is not None
    assert clock.shared.held == clock.held
    again = host_reads(clock, wall)  # nothing is made up for: what was held back is gone
    assert again - then == pytest.approx(2 * BLOCK)
    steps(clock, wall, 0.05)
    assert clock.rig.time - again == pytest.approx(0.05)


def test_a_host_that_is_silent_or_gone_is_not_waited_for(clock: Clock, wall: Wall) -> None:
    then = host_reads(clock, wall)
    steps(clock, wall, MAX_HOLD + 0.5)
    assert clock.rig.time - then == pytest.approx(2 * BLOCK + 0.5, abs=0.02)
    host_reads(clock, wall)
    then = host_reads(clock, wall)
    clock.client_disconnected()
    steps(clock, wall, 0.3)
    assert clock.rig.time - then == pytest.approx(0.3)


def test_while_its_own_process_does_not_run_nobody_is_late(clock: Clock, wall: Wall) -> None:
    then = host_reads(clock, wall)
    for _ in range(3):
        steps(clock, wall, 3.0, every=3.0)
        assert clock.rig.time - then == pytest.approx(2 * BLOCK)
    assert clock.held == pytest.approx(9.0 - 2 * BLOCK)


def test_a_host_that_waits_for_samples_gets_them(clock: Clock, wall: Wall) -> None:
    wanted: list[int] = []
    reading = threading.Thread(target=lambda: wanted.append(locked_read(clock, 500)))
    reading.start()
    while clock._wanted == 0:
        time.sleep(0.001)
    for _ in range(52):
        steps(clock, wall, 0.01)
    reading.join(10.0)
    assert wanted == [500]
    assert clock.held == 0.0


def locked_read(clock: Clock, n: int) -> int:
    with clock.locked():
        return len(clock.read(n, 5.0)[1])


def test_a_host_goes_by_the_rigs_time(tmp_path: Path) -> None:
    """It stands while the simulation does not run, and goes on from there."""
    shared = SharedClock(tmp_path / "clock")
    before = time.monotonic()
    shared.write(0.25, before)
    host = SharedClock(tmp_path / "clock")
    first = host()
    time.sleep(0.05)
    assert first == pytest.approx(before - 0.25, abs=1e-6)
    assert host() == pytest.approx(first, abs=1e-6)
    shared.write(0.25, time.monotonic() - MAX_HOLD - 2.0)  # it has ended: whoever waits does not wait for ever
    before, now, after = time.monotonic(), host(), time.monotonic()
    assert before <= now + 0.25 + MAX_HOLD <= after


def stroke(start: float, seconds: float = 2.0) -> Drive:
    t = np.arange(0.0, seconds, 0.01)
    return Drive(0.01, start + 0.002 * (1.0 - np.cos(2.0 * np.pi * t)), np.full(t.size, 1.0))


def process_of(module: str) -> int:
    """The process of this one that runs a module."""
    listed = subprocess.run(["ps", "-eo", "pid,ppid,args"], capture_output=True, text=True, check=True).stdout
    for line in listed.splitlines()[1:]:
        pid, parent, command = line.split(None, 2)
        if int(parent) == os.getpid() and module in command:
            return int(pid)
    raise AssertionError(f"{module} does not run")


def stopped_for(pid: int, seconds: float, times: int) -> threading.Thread:
    """Stop a process again and again, as a busy machine does."""

    def stop() -> None:
        for _ in range(times):
            time.sleep(0.3)
            os.kill(pid, signal.SIGSTOP)
            time.sleep(seconds)
            os.kill(pid, signal.SIGCONT)

    thread = threading.Thread(target=stop)
    thread.start()
    return thread


def play(rig: Rig, module: str, seconds: float, times: int) -> list[float]:
    with rig.armed() as table:
        table.home(here=True)
        stopping = stopped_for(process_of(module), seconds, times)
        try:
            played = [samples.displacement[selection] for samples, selection in table.play(stroke(table.position))]
        finally:
            stopping.join()
        return list(np.concatenate(played))


@pytest.mark.prove
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("module", ["dampyr.rig.simulation.server", "dampyr.rig.loop_server"])
def test_a_process_that_does_not_run_for_half_a_second_stops_no_simulated_rig(module: str) -> None:
    with simulated(real_time=True) as rig:
        x = play(rig, module, 0.5, 3)
        assert len(x) == 1991
        assert np.ptp(x) == pytest.approx(0.004, rel=0.1)
        assert rig.clock_held > 3 * (0.5 - 3 * BLOCK)


@pytest.mark.prove
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_host_that_is_silent_for_longer_meets_the_watchdog() -> None:
    with simulated(real_time=True) as rig, pytest.raises(RigFault, match="the host was silent for too long"):
        play(rig, "dampyr.rig.loop_server", 2.0, 1)


@pytest.mark.prove
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_record_says_for_how_long_the_clock_was_held_back(tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(
        'name = "one"\ncheck_amplitude = 0.0\n[[step]]\nkind = "sine"\namplitude = "4 mm"\nfrequency = "1 Hz"\n'
        'voltage = "0.8712 V"\ncycles = 4\n'
    )
    with simulated(real_time=True) as rig:
        stopping: list[threading.Thread] = []

        def watch(progress: object) -> None:
            if getattr(progress, "phase", "") == "testing" and not stopping:
                stopping.append(stopped_for(process_of("dampyr.rig.loop_server"), 0.5, 1))

        folder = perform(tmp_path / "one.toml", rig, tmp_path / "out", watch)
        stopping[0].join()
        held = rig.clock_held
    record = records.read(next(folder.glob("*.h5")))
    assert 0.3 < float(record.provenance["simulated_clock_held_back_s"]) <= held + 5e-4
    _, events = read_journal(folder)
    (event,) = [each for each in events if each.what == "clock held back"]
    assert "this machine was too busy" in event.detail
