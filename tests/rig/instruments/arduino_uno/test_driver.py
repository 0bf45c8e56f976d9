"""The first words with an Uno: its boot loader after the port is opened; an Uno armed, restarted, of another version."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product

import pytest

from dampyr.errors import DampyrWarning, InputError, RigFault
from dampyr.rig import Rig, RigSettings
from dampyr.rig.firmware import control_core as c
from dampyr.rig.firmware.protocol import QUEUE, VERSION, Fault, Reply, Request, SerialFrame, State, Status, encode
from dampyr.rig.firmware.twin import Twin
from dampyr.rig.instruments.arduino_uno import wire as wires
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess, Serial
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.simulation.simulator import Simulator, parse_faults


class Booting:
    """A serial port in simulated time: ``boot`` s of a boot loader after opening, then the firmware.

    A boot loader swallows what it gets, answers it with its own bytes, or is held by it: each byte keeps it ``hold`` s longer.
    """

    boot, answer = Serial.boot, Serial.answer

    def __init__(self, boots: float, chatter: bytes = b"", hold: float = 0.0, stale: bytes = b"") -> None:
        self.now, self.ready, self.chatter, self.hold = 100.0, 100.0 + boots, chatter, hold
        self.twin, self.input, self.early = Twin(), stale, 0

    def clock(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds

    def discard(self) -> None:
        self.input = b""

    def send(self, data: bytes) -> None:
        if self.now < self.ready:
            self.early += 1
            self.input += self.chatter
            self.ready = max(self.ready, self.now + self.hold)
        else:
            self.input += self.twin.receive(data)

    def receive(self) -> bytes:
        self.now += 0.02
        data, self.input = self.input, b""
        return data

    def close(self) -> None:
        pass


def uno_of(port: Booting) -> Uno:
    return Uno(port, clock=port.clock, sleep=port.sleep)


@pytest.mark.parametrize("boots", [0.0, 0.5, 1.6, 2.0, 2.6, 5.0])
@pytest.mark.parametrize("chatter", [b"", b"\x14\x10", b"\x00\xff\x03"])
def test_an_uno_is_met_after_its_boot_loader(boots: float, chatter: bytes) -> None:
    port = Booting(boots, chatter, stale=encode(SerialFrame(Reply.ACK, 7, (1, 1))) + b"\x05half")
    assert uno_of(port).hello().version == VERSION
    assert port.now - 100.0 < max(boots, Serial.boot) + 0.3
    if boots <= 2.0:
        assert port.early == 0  # what comes during the boot may be taken for a program


def test_a_boot_loader_that_traffic_would_hold_is_left_in_peace() -> None:
    port = Booting(2.0, b"\x15", hold=2.0)
    assert uno_of(port).hello().version == VERSION


def test_a_dead_uno_is_given_up_after_three_seconds_of_asking() -> None:
    port = Booting(1e9)
    with pytest.raises(
        RigFault, match=r"does not answer HELLO, asked \d+ times in 6\.\d s; check its cable, its power"
    ):
        uno_of(port).hello()
    assert port.now - 100.0 >= Serial.boot + 3.0
    assert port.early <= 20  # sensible spacing


def test_only_the_first_hello_waits() -> None:
    port = Booting(0.5)
    uno = uno_of(port)
    uno.hello()
    before = port.now
    uno.hello()
    assert port.now - before < 0.1


def test_nothing_is_waited_for_where_no_port_is_opened() -> None:
    simulator = Simulator(RigSettings())
    slept: list[float] = []
    Uno(InProcess(simulator.serial), sleep=slept.append).hello()
    silent = Uno(InProcess(lambda _: b""), sleep=slept.append)
    with pytest.raises(RigFault, match="asked 4 times"):
        silent.hello()
    assert slept == []
    assert wires.Tcp.boot == 0.0


@contextmanager
def arduino(boots: float) -> Iterator[str]:
    """A pseudo-terminal with an Uno at its end, just reset: a boot loader that answers rubbish, then the firmware."""
    import pty
    import select
    import tty

    near, far = pty.openpty()
    tty.setraw(near)
    over, twin, ready = threading.Event(), Twin(), time.monotonic() + boots

    def run() -> None:
        os.write(near, b"\x00\x14boot")
        while not over.is_set():
            if not select.select([near], [], [], 0.02)[0]:
                continue
            data = os.read(near, 256)
            os.write(near, b"\x15\x00" if time.monotonic() < ready else twin.receive(data))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield os.ttyname(far)
    finally:
        over.set()
        thread.join()
        os.close(near)
        os.close(far)


@pytest.mark.prove
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")
@pytest.mark.parametrize("boots", [1.6, *(pytest.param(each, marks=pytest.mark.prove) for each in (0.5, 2.0, 3.0))])
def test_a_serial_port_whose_uno_boots(boots: float) -> None:
    with arduino(boots) as port:
        uno = Uno(Serial(port, 250000))
        hello = uno.hello()
        status = uno.heartbeat()
        uno.close()
    assert hello.version == VERSION
    assert (status.state, status.faults) == (State.FAULT, Fault.RESTARTED)


# an Uno that is not as a new host expects it


def host(simulator: Simulator) -> Rig:
    return Rig(simulator.settings, Uno(InProcess(simulator.serial)), InProcessBoard(simulator), threaded=False)


def left_armed(simulator: Simulator) -> None:
    rig = host(simulator)
    rig.uno.hello()
    rig.uno.clear()
    rig.uno.configure(rig.settings)
    rig.uno.heartbeat()
    rig.uno.arm()


def test_an_uno_that_was_left_armed_is_said_by_name_and_taken_over() -> None:
    simulator = Simulator(RigSettings(), position=0.004)
    left_armed(simulator)
    rig = host(simulator)
    with pytest.warns(DampyrWarning, match="left in state ARMED by another host"), rig.armed() as table:
        table.home()
    with rig.armed() as table:
        assert table.homed


def test_an_uno_that_had_stopped_is_said_by_name_and_taken_over() -> None:
    simulator = Simulator(RigSettings(), position=-0.003)
    left_armed(simulator)
    simulator.run_unattended(0.5)
    words = "stopped by itself before this host came: the host was silent for too long"
    with pytest.warns(DampyrWarning, match=words), host(simulator).armed() as table:
        table.home()


def test_an_uno_that_restarts_is_said_by_name() -> None:
    simulator = Simulator(RigSettings())
    rig = host(simulator)
    with rig.armed() as table:
        table.home()
        simulator.faults = parse_faults([f"restarted-uno@{simulator.time + 0.5:.3f}s"])
        with pytest.raises(RigFault, match=r"started anew while it was in use.*home the table again") as raised:
            table.rest(2.0)
    assert raised.value.ring == "firmware"
    with rig.armed() as table:
        assert not table.homed
        table.home()


def test_firmware_of_another_version_is_said_by_name() -> None:
    def other(_: bytes) -> bytes:
        return b"".join(
            encode(SerialFrame(Reply.HELLO, number, (VERSION + 1, 0x0300, 1000, 64))) for number in range(256)
        )

    with pytest.raises(RigFault, match=rf"version {VERSION + 1} of the protocol and this dampyr {VERSION}; flash it"):
        Uno(InProcess(other)).hello()
    assert Request.HELLO == 1  # of every version: HELLO is how the two find out


# set points in several frames


class LosingLine(InProcess):
    """A line to a firmware that loses these frames of the host's and these replies, counted from 0 over all that is sent; with
    ``late`` a reply that is not lost comes with those to the next thing sent."""

    def __init__(self, twin: Twin, frames: set[int], replies: set[int], late: bool) -> None:
        self.twin, self.frames, self.replies, self.late = twin, frames, replies, late
        self.sent, self.sizes, self.kept = 0, [], b""
        super().__init__(self.pass_on)

    def pass_on(self, data: bytes) -> bytes:
        frames = [frame + b"\0" for frame in data.split(b"\0") if frame]
        self.sizes.append(len(frames))
        came, self.kept = (self.kept, b"") if self.late else (b"", b"")
        for frame in frames:
            reply = b"" if self.sent in self.frames else self.twin.receive(frame)
            reply = b"" if self.sent in self.replies else reply
            self.kept, came = (self.kept + reply, came) if self.late else (b"", came + reply)
            self.sent += 1
        return came


def armed_twin() -> tuple[Twin, Uno]:
    twin = Twin()
    uno = Uno(InProcess(twin.receive), wait=0.0)
    uno.hello()
    uno.clear()
    uno.configure(RigSettings())
    uno.home(0, 0)
    uno.heartbeat()
    uno.arm()
    return twin, uno


LOST = [set(), {0}, {1}, {2}, {0, 1}, {0, 2}, {1, 2}, {0, 1, 2}, {0, 3}, {2, 3}, {0, 3, 6}]


@pytest.mark.parametrize("late", [False, True])
def test_set_points_in_several_frames_arrive_whatever_is_lost(late: bool) -> None:
    points = [10 * k for k in range(40)]
    for frames, replies in product(LOST, repeat=2):
        twin, uno = armed_twin()
        uno._wire, uno.tries = LosingLine(twin, frames, replies, late), 12
        case = f"frames {frames} and replies {replies} are lost"
        assert uno.points(0, points) == QUEUE - 40, case
        assert list(twin.registers[c.R_QUEUE : c.R_QUEUE + 40]) == points, case
        assert twin.registers[c.R_NEXT] == 40, case
        assert uno._wire.sizes[0] == 3, case  # together: 16, 16 and 8
        if not (frames or replies or late):
            assert uno._wire.sizes == [3]


def test_set_points_that_do_not_fit_are_refused_with_the_reason() -> None:
    twin, uno = armed_twin()
    with pytest.raises(RigFault, match="refused SETPOINTS: its queue is full"):
        uno.points(0, [0] * 70)
    with pytest.raises(RigFault, match="refused SETPOINTS: set points are missing"):
        uno.points(int(twin.registers[c.R_NEXT]) + 1, [0] * 20)
    with pytest.raises(InputError, match="send at least one set point"):
        uno.points(0, [])


# a cause before its consequences


def test_a_stop_of_the_uno_comes_before_what_follows_from_it() -> None:
    """The host was away: the watchdog's stop is the cause, the distance between two readings its consequence."""
    simulator = Simulator(RigSettings())
    rig = host(simulator)
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        rig.uno.jog(8000, 500)
        next(table.loop.blocks())
        ask = rig.uno.heartbeat

        def late() -> Status:
            simulator.run_unattended(0.3)
            return ask()

        rig.uno.heartbeat = late  # type: ignore[method-assign]
        with pytest.raises(RigFault, match="the host was silent for too long"):
            next(table.loop.blocks())
        rig.uno.heartbeat = ask  # type: ignore[method-assign]
