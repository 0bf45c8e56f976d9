"""Any sequence of what a person may do with a rig, from anywhere, with any fault between: it is safe, and can be used again.

Judged by the simulator's ground truth: force, stroke and speed within their limits, the coil live only under a host's
heartbeats, no motion without a state that moves, nothing armed once its host has left. Whatever was raised is a
:class:`RigFault` or an :class:`InputError` that says what is wrong. In the end, with the faults over, the rig is armed and
homed again by what its own errors say.
"""

# ruff: noqa: PT017 - what leaving the block raises is judged and dropped

from __future__ import annotations

import re
import shutil
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule, run_state_machine_as_test
from tests.endurance import Endurance
from tests.rig.wires.clock import Clock
from tests.rig.wires.daqmx_service import start_server
from tests.rig.wires.process import open_wired
from tests.rig.wires.serial_wire import Serial

from dampyr.campaigns import RunControl, Stopped, perform
from dampyr.campaigns.run_control import Progress
from dampyr.errors import DampyrWarning, InputError, RigFault
from dampyr.rig import Drive, Rig, RigSettings
from dampyr.rig.firmware.protocol import State
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.interlock import Samples
from dampyr.rig.session import ArmedRig, no_check
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.faults import KINDS, FaultSpec
from dampyr.rig.simulation.simulator import Simulator

STOP = 0.037  # m: the damper's
MIDDLE = 4e-4  # m about the middle within which a table is homed by hand
GIVES = 4.5e-4  # m that its stop gives under the rig's largest force
BRAKED = 0.15  # s after which a table that is not driven stands
WATCHED = 0.6  # s after which a table without a host stands: the watchdog acts after 0.15 s
HOMES = re.compile("home the table|home by hand")
FREES = re.compile("towards the middle|moves the table away")
AGAIN = re.compile(
    "does not answer|error -200284|error -200279|error -200290|look at the encoder|release it|aborted|"
    "is the motor blocked|is the motor|look at its wire|look at the motor|broken|cool"
)
CAMPAIGN = """
name = "short"
rest_between = "0.1 s"
check_amplitude = "{check} mm"
[[step]]
kind = "sine"
amplitude = "3 mm"
frequency = "2 Hz"
voltage = ["1.5 V", "0 V"]
cycles = 1
rest_before = "0.1 s"
"""


class Interrupted(Exception):
    """What a person's button raises in a wait, as the console's does."""


class Killed(BaseException):
    """The host's process ends at once; nothing of it runs on."""


@dataclass(frozen=True)
class FaultPlan:
    """A fault that begins some time after something is asked for."""

    kind: str
    delay: float
    lasts: float
    share: float


Event = FaultPlan | tuple[str, int] | None
FAULTS = st.builds(
    FaultPlan,
    st.sampled_from([name for name in KINDS if name != "hot-specimen"]),
    st.sampled_from([0.0, 0.05, 0.3, 1.0]),
    st.sampled_from([0.5, 0.1, 0.02, 2.0]),
    st.sampled_from([1.0, -1.0, 0.1, 0.01]),
)
BUTTONS = st.tuples(st.sampled_from(["abort", "stop", "Ctrl-C", "kill"]), st.sampled_from([1, 0, 5, 20, 80]))
EVENTS = st.none() | FAULTS | BUTTONS


class Bench(RuleBasedStateMachine):
    """A simulated rig in this process and whoever uses it."""

    def __init__(self) -> None:
        super().__init__()
        self.rig: Rig | None = None
        self.gone: Rig | None = None
        self.table: ArmedRig | None = None
        self.block: Any = None
        self.folder = Path(tempfile.mkdtemp(prefix="dampyr-any-"))
        self.campaigns = 0
        self.judged = 0.0
        self.placed = False  # by the index
        self.beats: list[float] = []
        self.log: list[str] = []

    # the rig and its hosts

    def host(self) -> Rig:
        """A new host of the rig."""
        board = InProcessBoard(self.simulator)
        return Rig(self.simulator.settings, Uno(InProcess(self.simulator.serial)), board, threaded=False)

    def idle(self, seconds: float) -> None:
        """Time passes without a host."""
        self.simulator.run_unattended(seconds)

    def vanish(self) -> None:
        """The host's process is gone; its board's task ends with it, and the Uno is left to itself."""
        self.simulator.stop()
        self.idle(WATCHED)

    def close(self) -> None:
        """The host lets go of the rig."""
        assert self.rig is not None
        self.rig.close()

    def make(self, rig: RigSettings, position: float) -> None:
        """The rig on the table."""
        self.simulator = Simulator(rig, position=position)
        self.simulator.delay_read = lambda _: None

    @initialize(
        place=st.sampled_from([0, -369, -340, -200, -30, 10, 20, 150, 290, 369]) | st.integers(-369, 369),
        wired=st.sampled_from(range(16)),
        begun=st.sampled_from(["homed", "homed by hand", "armed", "new"]),
    )
    def begin(self, place: int, wired: int, begun: str) -> None:
        base, position = RigSettings(), 1e-4 * place
        switches, stop, index, thermocouple = (bool(wired & bit) for bit in (1, 2, 4, 8))
        wires = replace(base.wires, end_switches=switches, emergency_stop=stop)
        wires = replace(wires, index=base.wires.index if index else "", temperature="ai1" if thermocouple else "")
        self.make(replace(base, wires=wires), position)
        self.beat, self.simulator.twin.on_heartbeat = self.simulator.twin.on_heartbeat, self.hear
        self.connect()
        if begun != "new":
            self.arm()
        if begun.startswith("homed"):
            self.home(here="hand" in begun, event=None)

    def hear(self) -> None:
        self.beats.append(self.simulator.time)
        self.beat()

    # what is allowed to be raised

    @contextmanager
    def said(self, what: str) -> Iterator[None]:
        """Whatever is asked for either works or says what is wrong; a host that was killed says nothing."""
        self.log.append(f"{self.simulator.time:.3f} {what}")
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            try:
                yield
            except Killed as problem:
                self.leave(problem)
            except Interrupted:
                pass
            except (RigFault, InputError) as problem:
                self.log.append(f"{self.simulator.time:.3f} {type(problem).__name__}: {problem}")
                check_sentence(problem)
                if isinstance(problem, RigFault):
                    self.leave(problem)
        for each in warned:
            assert issubclass(each.category, DampyrWarning), each
            assert re.search("the Uno|the encoder's index was not where", str(each.message))
        self.check()

    def leave(self, problem: BaseException | None) -> None:
        """Leave the block in which the rig is armed, as ``problem`` makes a program do."""
        if isinstance(problem, Killed):
            self.gone, self.rig, self.table, self.block = self.rig, None, None, None
            self.vanish()
        elif self.block is not None:
            block, self.table, self.block = self.block, None, None
            kind = None if problem is None else type(problem)
            try:
                assert not block.__exit__(kind, problem, None if problem is None else problem.__traceback__)
            except BaseException as raised:
                if raised is not problem:
                    assert problem is None
                    assert isinstance(raised, RigFault)
                    check_sentence(raised)
            if self.talks:
                assert not self.simulator.twin.enabled
            self.idle(0.0 if self.talks else WATCHED)
            self.check_left()

    @property
    def talks(self) -> bool:
        """Whether the serial wire works."""
        return self.simulator._active_fault("unplugged-serial", "lost-bytes") is None

    # what a person does

    @precondition(lambda self: self.rig is None)
    @rule()
    def connect(self) -> None:
        with self.said("connect"):
            self.rig = self.host()
            self.rig.identity  # noqa: B018 - looked at by every program first

    @precondition(lambda self: self.rig is not None and self.table is None)
    @rule(new=st.booleans())
    def disconnect(self, new: bool) -> None:
        with self.said("disconnect"):
            self.close()
        self.rig = None
        self.idle(WATCHED)
        self.check_left()
        if new:
            self.connect()

    @precondition(lambda self: self.rig is not None and self.table is None)
    @rule()
    def arm(self) -> None:
        assert self.rig is not None
        with self.said("arm"):
            block = self.rig.armed()
            self.table = block.__enter__()
            self.block = block
            if self.placed and self.table.homed and not self.simulator.faults:
                self.check_place()
        if self.block is None:
            self.check_left()

    @precondition(lambda self: self.table is not None)
    @rule(how=st.sampled_from(["disarm", "abort", "stop", "Ctrl-C", "an error", "kill"]))
    def end(self, how: str) -> None:
        """The block in which the rig is armed is left in one of the ways in which it can be."""
        with self.said(how):
            assert self.table is not None
            if how == "kill":
                raise Killed
            if how == "abort":
                self.table.abort("by a test")
                next(iter(self.table.loop.blocks()))
            if how == "stop":
                self.table.stop()
            self.leave({"Ctrl-C": KeyboardInterrupt(), "an error": ValueError("in a script")}.get(how))

    @precondition(lambda self: self.rig is not None)
    @rule(seconds=st.sampled_from([0.1, 1.0]), event=EVENTS)
    def wait(self, seconds: float, event: Event) -> None:
        if self.table is not None:
            with self.said(f"rest {seconds} {event}"), self.event(event):
                self.table.rest(seconds)
        else:
            self.begin_fault(event)
            self.idle(seconds)

    @precondition(lambda self: self.table is not None)
    @rule(here=st.booleans(), event=EVENTS)
    def home(self, here: bool, event: Event) -> None:
        # by hand in the middle only: where it is done elsewhere, nothing but the force keeps the table off the damper's stops
        here = here and abs(float(self.simulator.plant[plant.Y_X])) < MIDDLE
        with self.said(f"home here={here} {event}"), self.event(event):
            assert self.table is not None
            self.placed = False
            self.table.home(here=here)
            self.placed = not here
            if self.placed and not self.simulator.faults:
                self.check_place()

    @precondition(lambda self: self.table is not None)
    @rule(
        speed=st.sampled_from([0.002, -0.002, 0.06, -0.03, 0.01, -0.2]),
        seconds=st.sampled_from([0.5, 0.3, 0.05, 0.0, 0.6]),
        waits=st.booleans(),
        event=EVENTS,
    )
    def jog(self, speed: float, seconds: float, waits: bool, event: Event) -> None:
        with self.said(f"jog {speed} {seconds} {waits} {event}"), self.event(event):
            assert self.table is not None
            self.table.jog(speed, seconds, wait=waits)

    @precondition(lambda self: self.table is not None)
    @rule(to=st.sampled_from([0.0, 0.011, -0.02, 0.002, -0.0364, 0.0364, 0.0368, -0.05]), event=EVENTS)
    def go(self, to: float, event: Event) -> None:
        with self.said(f"go {to} {event}"), self.event(event):
            assert self.table is not None
            self.table.go(to)

    @precondition(lambda self: self.table is not None)
    @rule(cycles=st.sampled_from([1, 3]), event=EVENTS)
    def play(self, cycles: int, event: Event) -> None:
        """Strokes about where the table stands."""
        with self.said(f"play {cycles} {event}"), self.event(event):
            assert self.table is not None
            t = np.arange(round(cycles / 0.02) + 1) * 0.01
            path = self.table.position + 0.005 * np.sin(4 * np.pi * t) * np.minimum(1, np.minimum(t, t[-1] - t) * 4)
            for _ in self.table.play(Drive(0.01, path, np.full(t.size, 1.5))):
                pass

    @precondition(lambda self: self.rig is not None and self.table is None)
    @rule(check=st.sampled_from([0, 1]), event=EVENTS | st.tuples(st.just("pause"), st.sampled_from([5, 60])))
    def start(self, check: int, event: Event) -> None:
        """A short campaign of two tests, and something that happens at some block of it."""
        assert self.rig is not None
        path, control, seen = self.folder / "short.toml", RunControl(), 0
        path.write_text(CAMPAIGN.format(check=check), "utf-8")
        self.campaigns += 1

        def watch(progress: Progress) -> None:
            if control.paused and progress.phase == "paused":
                control.resume()

        def press(_: Samples) -> None:
            nonlocal seen
            seen += 1
            if isinstance(event, FaultPlan) or event is None or seen - 1 != event[1]:
                return
            if event[0] == "kill":
                raise Killed
            if event[0] == "Ctrl-C":
                raise KeyboardInterrupt
            getattr(control, event[0])()

        self.begin_fault(event)
        self.rig.watchers.append(press)
        with self.said(f"start check={check} {event}"):
            try:
                with suppress(Stopped, KeyboardInterrupt):
                    perform(path, self.rig, self.folder / str(self.campaigns), watch, control)
            finally:
                self.rig.watchers.remove(press)
        if self.rig is not None:
            self.idle(0.0 if self.talks else WATCHED)
            self.check_left()

    def begin_fault(self, event: Event) -> None:
        """Plan a fault, from now on."""
        if isinstance(event, FaultPlan):
            kind = KINDS[event.kind]
            share = event.share if kind.signed else abs(event.share)
            amount = None if kind.amount is None else kind.amount * share
            begin = round(self.simulator.time + 0.001 + event.delay, 4)
            self.simulator.faults = (
                *self.simulator.faults,
                FaultSpec(event.kind, begin, event.lasts, amount),
            )
            self.log.append(f"{self.simulator.time:.3f} fault {self.simulator.faults[-1]}")

    @contextmanager
    def event(self, event: Event) -> Iterator[None]:
        """Something that happens at some block of a motion: a fault, or a button."""
        assert self.table is not None
        table, seen = self.table, 0
        self.begin_fault(event)

        def press() -> None:
            nonlocal seen
            seen += 1
            if event is None or isinstance(event, FaultPlan) or seen - 1 != event[1]:
                return
            if event[0] == "abort":
                table.abort("by a test")
            elif event[0] == "kill":
                raise Killed
            elif event[0] == "stop":
                raise Interrupted
            elif event[0] == "Ctrl-C":
                raise KeyboardInterrupt

        table.check = press
        try:
            yield
        except Interrupted:
            table.stop()
            raise
        except KeyboardInterrupt as problem:
            self.leave(problem)
        finally:
            table.check = no_check

    # what has to be so

    def check(self) -> None:
        """The ground truth since the last look."""
        truth = self.simulator.truth
        new = truth.time > self.judged
        limits = self.simulator.settings.limits
        assert np.abs(truth.force[new]).max(initial=0.0) <= limits.force, self.history()
        assert np.abs(truth.speed[new]).max(initial=0.0) <= limits.speed, self.history()
        assert np.abs(truth.position[new]).max(initial=0.0) <= STOP + GIVES, self.history()
        live = new & (truth.voltage != 0.0)
        if live.any():
            beats = np.array(self.beats)
            last = beats[np.searchsorted(beats, truth.time[live], side="right") - 1]
            assert (truth.time[live] - last).max() <= limits.heartbeat + 0.002, self.history()
        moves = (truth.state >= State.FOLLOWING) & (truth.state <= State.STOPPING)
        since = np.where(moves, truth.time, 0.0)
        undriven = new & (truth.time - np.maximum.accumulate(since) > BRAKED)
        assert np.all(truth.speed[undriven] == 0.0), self.history()
        self.judged = float(truth.time[-1]) if truth.time.size else 0.0

    def check_left(self) -> None:
        """Nothing is armed, moves or has voltage."""
        self.check()
        assert not self.simulator.twin.enabled, self.history()
        assert self.simulator.command == 0.0, self.history()
        assert self.simulator.timed is None or self.simulator.timed.empty(self.simulator.time), self.history()

    def check_place(self) -> None:
        """Homed by the index: the Uno's position is the table's, and so is the board's."""
        assert self.table is not None
        block = next(self.table.loop.blocks())
        true = self.simulator.truth.position[-1]
        assert self.table.position == pytest.approx(true, abs=1.6e-5), self.history()
        assert block.displacement[-1] == pytest.approx(true, abs=1.6e-5), self.history()

    def history(self) -> str:
        """What was done so far."""
        return "\n".join(self.log)

    def teardown(self) -> None:
        try:
            if hasattr(self, "simulator"):
                self.recover()
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)

    def recover(self) -> None:
        """With the faults over, the rig is armed and homed again by what its errors say."""
        if self.table is not None:
            with self.said("disarm at the end"):
                self.leave(None)
        over = max((fault.until for fault in self.simulator.faults if np.isfinite(fault.until)), default=0.0)
        self.idle(max(over - self.simulator.time, 0.0) + 0.1)
        message = ""
        for _ in range(4):
            if self.rig is None:
                self.connect()
            self.arm()
            if self.table is not None and self.table.homed and not HOMES.search(message):
                self.go(to=0.0, event=None)
            if self.table is not None:
                self.home(here=False, event=None)
            if self.table is not None:
                self.go(to=-0.005, event=None)
            if self.table is not None:
                self.check_place()
                self.end("disarm")
                return
            message = self.log[-1]
            assert HOMES.search(message) or FREES.search(message) or AGAIN.search(message), self.history()
        raise AssertionError(f"it could not be armed and homed again:\n{self.history()}")


class WiredBench(Bench):
    """The same over the wires: pyserial's socket and NI-DAQmx's gRPC, with the clock of a rig in a process of its own.

    Its server is a thread of this process, so that its truth can be looked at and its faults be set.
    """

    def make(self, rig: RigSettings, position: float) -> None:
        super().make(rig, position)
        self.clock = Clock(self.simulator, EventFile(None))
        self.simulator.delay_read = lambda _: None
        self.server, port = start_server(self.clock)
        self.serial = Serial(self.clock)
        wires = replace(rig.wires, serial=f"socket://127.0.0.1:{self.serial.port}", grpc=f"127.0.0.1:{port}")
        self.wired = replace(rig, wires=wires)
        self.clock.start()

    def host(self) -> Rig:
        until = time.monotonic() + 10.0
        while self.serial.busy and time.monotonic() < until:  # the server sees a moment later that a host has gone
            time.sleep(0.002)
        uno, board = open_wired(self.wired)
        return Rig(self.simulator.settings, uno, board, threaded=False)

    def idle(self, seconds: float) -> None:
        with self.clock.lock:
            super().idle(seconds)

    def vanish(self) -> None:
        """Its sockets are closed, and nothing was said to the board."""
        assert self.gone is not None
        self.gone.uno.close()
        self.idle(WATCHED)

    def check(self) -> None:
        with self.clock.lock:
            super().check()

    def teardown(self) -> None:
        try:
            super().teardown()
        finally:
            if hasattr(self, "clock"):
                if self.rig is not None:
                    self.rig.close()
                self.clock.finished.set()
                self.serial.listener.close()
                self.server.stop(None)


def check_sentence(problem: Exception) -> None:
    """It is said what is wrong, in words."""
    words = str(problem)
    assert len(words.split()) >= 3, words
    assert not re.search(r"Traceback|Error\b|reading the rig failed|no reason given|object at 0x", words), words


def run(machine: Callable[[], RuleBasedStateMachine], examples: int, steps: int = 12, seeded: bool = True) -> None:
    """Run a state machine with examples that are the same each time."""
    run_state_machine_as_test(
        machine,
        settings=settings(
            max_examples=examples,
            stateful_step_count=steps,
            deadline=None,
            derandomize=seeded,
            database=None,
            suppress_health_check=list(HealthCheck),
        ),
    )


def test_any_sequence() -> None:
    run(Bench, 2, 8)


@pytest.mark.prove
@pytest.mark.endure
def test_many_sequences(endurance: Endurance) -> None:
    count = 2000 if endurance.full else 2
    run(Bench, count, 16)
    endurance.report(
        "what a person may do with a rig in random order, with faults between, from anywhere",
        None,
        f"{count} sequences of 16 steps; always safe, and each rig was armed and homed again",
    )


@pytest.mark.prove
@pytest.mark.endure
def test_many_sequences_over_the_wires(endurance: Endurance) -> None:
    count, steps = (100, 10) if endurance.full else (1, 4)
    run(WiredBench, count, steps)
    endurance.report(
        "the same over the wires of the simulated rig",
        None,
        f"{count} sequences of {steps} steps; always safe, and usable again",
    )
