"""The simulated rig in real time: its clock waits for a host, and for its own process, on a busy machine."""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.rig.served_loop import reader_of
from tests.rig.simulation.driver import PROMPT

from dampyr import records
from dampyr.campaigns import perform, read_journal
from dampyr.rig import Drive, Rig, RigSettings, simulated
from dampyr.rig.firmware.protocol import State
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.simulation import real_time
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.instrument_ends import Simulation, simulate_instruments
from dampyr.rig.simulation.real_time import MAX_HOLD, RealTimeSimulator
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.specimen import original_specimen

BLOCK, RATE = RigSettings().board.block, RigSettings().board.rate


class Wall:
    """A wall clock that goes by hand."""

    def __init__(self) -> None:
        self.now, self.sleep = 1000.0, time.sleep

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def wall(monkeypatch: pytest.MonkeyPatch) -> Wall:
    made = Wall()
    monkeypatch.setattr(real_time, "time", made)
    return made


@pytest.fixture
def rig(wall: Wall) -> Iterator[RealTimeSimulator]:
    made = RealTimeSimulator(RigSettings())
    made.start(RATE)
    yield made
    made._over.set()


def steps(rig: RealTimeSimulator, wall: Wall, seconds: float, every: float = 0.01) -> None:
    for _ in range(round(seconds / every)):
        with rig._lock:
            wall.now += every
            rig._follow()


def host_reads(rig: RealTimeSimulator, wall: Wall) -> float:
    """A host has read all that there was; the rig's time."""
    steps(rig, wall, BLOCK)
    rig.read(rig.waiting)
    return rig.time


def test_a_host_that_keeps_up_holds_nothing_back(rig: RealTimeSimulator, wall: Wall) -> None:
    for _ in range(50):
        host_reads(rig, wall)
    assert rig.held == 0.0
    assert rig.time == pytest.approx(50 * BLOCK)
    assert rig.clock() == wall.now


def test_a_late_host_is_waited_for_two_blocks_ahead(rig: RealTimeSimulator, wall: Wall) -> None:
    then = host_reads(rig, wall)
    steps(rig, wall, 0.5)
    assert rig.time - then == pytest.approx(2 * BLOCK)
    assert rig.held == pytest.approx(0.5 - 2 * BLOCK)
    assert rig.clock() == wall.now - rig.held
    again = host_reads(rig, wall)  # nothing is made up for: what was held back is gone
    assert again - then == pytest.approx(2 * BLOCK)
    steps(rig, wall, 0.05)
    assert rig.time - again == pytest.approx(0.05)


def test_a_host_that_is_silent_or_samples_nothing_is_not_waited_for(rig: RealTimeSimulator, wall: Wall) -> None:
    then = host_reads(rig, wall)
    steps(rig, wall, MAX_HOLD + 0.5)
    assert rig.time - then == pytest.approx(2 * BLOCK + 0.5, abs=0.02)
    host_reads(rig, wall)
    then = host_reads(rig, wall)
    rig.stop()
    steps(rig, wall, 0.3)
    assert rig.time - then == pytest.approx(0.3)


def test_while_its_own_process_does_not_run_nobody_is_late(rig: RealTimeSimulator, wall: Wall) -> None:
    then = host_reads(rig, wall)
    for _ in range(3):
        steps(rig, wall, 3.0, every=3.0)
        assert rig.time - then == pytest.approx(2 * BLOCK)
    assert rig.held == pytest.approx(9.0 - 2 * BLOCK)
    stands = rig.clock()
    wall.now += 5.0  # it does not run
    assert rig.clock() == stands


def test_a_host_that_waits_for_samples_gets_them(rig: RealTimeSimulator, wall: Wall) -> None:
    wanted: list[int] = []
    reading = threading.Thread(target=lambda: wanted.append(len(rig.read(500)[1])))
    reading.start()
    while rig._wanted == 0:
        time.sleep(0.001)
    for _ in range(52):
        steps(rig, wall, 0.01)
    reading.join(10.0)
    assert wanted == [500]
    assert rig.held == 0.0


def test_a_request_is_answered_at_the_time_that_it_is(rig: RealTimeSimulator, wall: Wall) -> None:
    board = InProcessBoard(rig)
    board.stop()
    with rig._lock:
        wall.now += 0.123
        board.start(RATE, np.full(100, 2.0))
        assert rig.timed is not None
        assert rig._task is not None
        assert rig.timed.start == rig._task.start == rig.time == pytest.approx(0.123)
        wall.now += 0.010
        rig.write(1.0)
        assert rig.time == pytest.approx(0.133)
    steps(rig, wall, 0.002, 0.001)
    board.write(0.0)
    assert rig.timed is None
    assert rig.command == 0.0


def test_a_delay_of_the_board_holds_up_nobody_else(wall: Wall) -> None:
    rig = RealTimeSimulator(RigSettings(uno=PROMPT), faults=[FaultSpec.parse("late-samples=30s@0s")])
    slept: list[float] = []
    states: list[State] = []

    def ask() -> None:
        rig.serial(b"")
        states.append(State(rig.twin.state))

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        other = threading.Thread(target=ask)
        other.start()
        other.join(10.0)

    wall.sleep = sleep  # type: ignore[assignment]
    rig.start(RATE)
    steps(rig, wall, BLOCK)
    rig.read(10)
    rig._over.set()
    assert slept == [30.0]
    assert len(states) == 1


def test_without_a_host_it_comes_to_rest_before_it_ends() -> None:
    simulator = Simulation(RigSettings(), original_specimen()).in_real_time()
    uno, board = simulate_instruments(RigSettings(), simulator)
    uno.hello()
    uno.clear()
    uno.configure(RigSettings())
    uno.heartbeat()
    uno.home(0, 0)
    uno.arm()
    board.write(1.0)
    uno.jog(2000, 400)
    assert simulator.twin.enabled
    simulator.close()
    assert not simulator.twin.enabled
    assert simulator.time - simulator.at_rest_since > 0.0
    assert simulator.time - simulator.coil_dead_since > 0.0
    assert simulator.truth.time.size == 0  # it may run for days
    stands = simulator.time
    time.sleep(0.05)
    assert simulator.time == stands


def test_it_gives_what_the_rig_in_lockstep_gives() -> None:
    """The samples of a table at rest, to the last bit: only the times at which it is states differ."""
    quiet = [Simulator(RigSettings(), 3), RealTimeSimulator(RigSettings(), 3)]
    for simulator in quiet:
        simulator.start(RATE)
    forces = [np.concatenate([simulator.read(40)[0][0] for _ in range(5)]) for simulator in quiet]
    quiet[1].close()
    np.testing.assert_array_equal(*forces)


def stroke(start: float, seconds: float = 2.0) -> Drive:
    t = np.arange(0.0, seconds, 0.01)
    return Drive(0.01, start + 0.002 * (1.0 - np.cos(2.0 * np.pi * t)), np.full(t.size, 1.0))


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


def play(rig: Rig, seconds: float, times: int) -> list[float]:
    with rig.armed() as table:
        table.home(here=True)
        stopping = stopped_for(reader_of(rig), seconds, times)
        try:
            played = [samples.displacement[selection] for samples, selection in table.play(stroke(table.position))]
        finally:
            stopping.join()
        return list(np.concatenate(played))


@pytest.mark.prove
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(("seconds", "times"), [(0.5, 3), (2.0, 1)])
def test_a_process_that_does_not_run_for_a_while_stops_no_simulated_rig(seconds: float, times: int) -> None:
    with simulated(real_time=True) as rig:
        x = play(rig, seconds, times)
        assert len(x) == 1991
        assert np.ptp(x) == pytest.approx(0.004, rel=0.1)
        assert rig.clock_held > times * (seconds - 3 * BLOCK)


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
                stopping.append(stopped_for(reader_of(rig), 0.5, 1))

        folder = perform(tmp_path / "one.toml", rig, tmp_path / "out", watch).folder
        stopping[0].join()
        held = rig.clock_held
    record = records.read(next(folder.glob("*.h5")))
    assert 0.3 < float(record.provenance["simulated_clock_held_back_s"]) <= held + 5e-4
    _, events = read_journal(folder)
    (event,) = [each for each in events if each.what == "clock held back"]
    assert "this machine was too busy" in event.detail
