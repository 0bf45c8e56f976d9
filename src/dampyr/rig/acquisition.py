"""Acquisition loop: it reads, checks and feeds one block of samples at a time, independently of its readers.

On a real rig, and on a simulated one in real time, it has a thread of its own, so that no slow disk or page delays the
interlock. A simulated rig in lockstep has no clock but its reads, and is read when its blocks are asked for.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import RigFault
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import Fault, State, Status
from dampyr.rig.instruments.contract import HERE, INDEX, Board, TableDrive
from dampyr.rig.interlock import Interlock, Samples
from dampyr.rig.loop import SETTLED, WaitingBlocks
from dampyr.rig.player import Player, player_of
from dampyr.rig.read_latency import Lateness
from dampyr.rig.settings import RigSettings
from dampyr.rig.thermal_model import Warmth
from dampyr.rig.uno_clock import ClockRatio, UnoClock

Array = NDArray[np.float64]
AHEAD = 5  # blocks by which the command runs ahead of the reading: 0.2 s of reserve for a late host and a slow line

WORDS = {
    Fault.HEARTBEAT: "the host was silent for too long",
    Fault.LOW: "the table passed the lower end of the stroke",
    Fault.HIGH: "the table passed the upper end of the stroke",
    Fault.SPEED: "the table was too fast",
    Fault.STALL: "the motor was driven and nothing moved: is the motor blocked, overloaded or unpowered, or the encoder dead?",
    Fault.FOLLOWING: "the table fell behind its set points: is the motor blocked, or is the drive too fast for its load?",
    Fault.UNDERRUN: "set points came too late",
    Fault.ENCODER: "the encoder's signals are broken, or its count leapt farther than any motor moves: look at its wires and "
    "at how scale and reading head are held, and home the table again",
    Fault.ABORTED: "it was aborted",
    Fault.RESTARTED: "the Uno had started anew; home the table again",
    Fault.INDEX: "the encoder's index was not where homing put it, so counts were lost or the scale has slipped; look at the "
    "encoder and its wires, and home the table again",
    Fault.END: "an end switch opened: the table reached its end, or the switch's wire is broken",
    Fault.EMERGENCY: "the emergency stop was pressed, or its wire is broken",
    Fault.DIRECTION: "the table moved against its motor: are the encoder's lines A and B, or the motor's leads, swapped?",
    Fault.CURRENT: "the motor's current was above actuator.max_current: is the table blocked, the load too large or a lead "
    "shorted?",
}
UNHOMED_SPEED_WORDS = (
    "the table was faster than 5 mm/s where it may only be slow (not homed, or outside of its limits): is there play in the "
    "screw or its mounts that the motor crossed, does the load push the table, or did the encoder leap?"
)


def fault_in_words(faults: Fault, slow: bool = False) -> str:
    """The reasons why the Uno stopped, as words; ``slow``: the table was one that may only move slowly."""
    words = WORDS | ({Fault.SPEED: UNHOMED_SPEED_WORDS} if slow else {})
    return " and ".join(words[fault] for fault in WORDS if fault in faults) or "no reason given"


def fault_of(status: Status) -> RigFault | None:
    """The fault in which the Uno stands; None where it stands in none."""
    if status.state is not State.FAULT:
        return None
    return RigFault(
        f"the Uno stopped the table: {fault_in_words(status.faults, not status.homed or status.outside)}", "firmware"
    )


class Acquisition:
    """The `dampyr.rig.loop.Loop` of this process: it reads, judges and feeds a rig, in a thread where it is ``threaded``."""

    def __init__(
        self,
        rig: RigSettings,
        uno: TableDrive,
        board: Board,
        calibration: Calibration,
        interlock: Interlock | None,
        warmth: Warmth,
        threaded: bool,
        watchers: Sequence[Callable[[Samples], None]] = (),
        clock: Callable[[], float] | None = time.monotonic,
        uno_clock: UnoClock | None = None,
    ) -> None:
        self.rig, self.uno, self.board, self.calibration = rig, uno, board, calibration
        self.interlock, self.warmth, self.threaded = interlock, warmth, threaded
        self.watchers, self.clock, self.uno_clock = watchers, clock, uno_clock or UnoClock()
        self._index = interlock.index if interlock is not None else {}  # where the encoder's index is passed
        self.lock = threading.RLock()
        self.player: Player | None = None
        # Whether the board's counts mean what the Uno's mean; where not, the next block sees to it.
        self.aligned = False
        self._next = 0
        self.stopped: RigFault | None = None
        self.status: Status = uno.heartbeat()
        self._command = np.zeros(0)  # coil volts of samples not read yet, for a coil at 20 degC
        self._factors = np.zeros(0)  # by how much more was output, for the coil's warmth
        self._ahead = rig.block_samples * AHEAD
        self._timed = False
        self._late = Lateness(rig.board.rate)
        self._over = threading.Event()
        self.waiting = WaitingBlocks(rig.board.block, self.halt)
        self._thread = threading.Thread(target=self._run, name="acquisition", daemon=True) if threaded else None

    def begin(self) -> None:
        """Start sampling with the coil at 0 V; the board counts from 0, wherever the table stands."""
        self.calibration = replace(self.calibration, middle=0.0)
        self.warmth.restart()
        self.uno_clock.restart()
        self._command, self._factors = np.zeros(self._ahead), np.ones(self._ahead)
        self.board.start(self.rig.board.rate, self._command)
        self._timed = True
        if self._thread:
            self._thread.start()

    @property
    def next(self) -> int:
        """The next sample that will be read."""
        return self._next

    @property
    def index(self) -> dict[int, int]:
        """Where the encoder's index is passed, counts from the middle; see `Interlock`."""
        return dict(self._index)

    @property
    def clock_ratio(self) -> ClockRatio:
        """The Uno's clock against the board's, as far as it is known."""
        return self.uno_clock.ratio

    @property
    def queued(self) -> int:
        """The first sample whose command is not fixed yet."""
        return self._next + len(self._command)

    @property
    def over(self) -> bool:
        """Whether it was ended."""
        return self._over.is_set()

    @property
    def reading(self) -> bool:
        """Whether its thread still reads."""
        return bool(self._thread and self._thread.is_alive())

    def blocks(self) -> Iterator[Samples]:
        """Blocks as they arrive, without end."""
        while True:
            if self.stopped:
                raise self.stopped
            yield self.waiting.take() if self._thread else self.cycle()

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                self.waiting.put(self.cycle())
            except RigFault as problem:
                self.halt(problem)
            except Exception as problem:  # whatever it is: a thread that died would leave the table to the watchdog
                self.halt(RigFault(f"reading the rig failed: {type(problem).__name__}: {problem}", "interlock"))
            if self.stopped:
                self.waiting.stop(self.stopped)
                return

    def cycle(self, n: int | None = None) -> Samples:
        """Read a block, check it, and queue the next command."""
        n = self.rig.block_samples if n is None else n
        try:
            volts, counts = self.board.read(n)
            passes = self.board.index_counts()
            waiting = self._late.of(self._next + n, self.clock()) if self.clock else 0.0
            with self.lock:
                status = self.uno.heartbeat()
                self.uno_clock.take((self._next + n) / self.rig.board.rate + waiting, status.time)
                samples = self._samples(volts, counts, passes, status)
                self._judge(samples, waiting)
                self._feed(samples)
        except RigFault as problem:
            raise self.halt(problem) from None
        for watch in self.watchers:
            watch(samples)
        return samples

    def _samples(self, volts: Array, counts: NDArray[np.int64], passes: NDArray[np.int64], status: Status) -> Samples:
        n, first = len(counts), self._next
        voltage, self._command = self._command[:n], self._command[n:]
        factors, self._factors = self._factors[:n], self._factors[n:]
        if len(voltage) < n:  # the timed command has ended: the coil is at 0 V
            voltage = np.concatenate([voltage, np.zeros(n - len(voltage))])
            factors = np.concatenate([factors, np.ones(n - len(factors))])
        asked, command, readings = voltage, voltage * factors, dict(zip(self.rig.inputs, volts, strict=True))
        if "coil_voltage" in readings:
            voltage = readings["coil_voltage"] * self.rig.supply.voltage_scale / factors
        self._next, self.status = first + n, status
        if not (status.homed and self.aligned):
            passes = passes[:0]  # what they are counted from is not certain yet
        if status.homed and not self.aligned:
            self._align(counts, status)
        self.aligned = status.homed
        calibration, player = self.calibration, self.player
        return Samples(
            first,
            np.arange(first, first + n) / self.rig.board.rate,
            calibration.displacement(counts),
            calibration.force(volts[0]),
            calibration.temperature(readings["temperature"]) if "temperature" in readings else None,
            volts,
            counts,
            voltage,
            status,
            passes - round(calibration.middle),
            command,
            None if player is None else player.target(first, n),
            asked,
        )

    def _align(self, counts: NDArray[np.int64], status: Status) -> None:
        """Move the middle to where the Uno has it, before a block is judged; the table itself did not jump."""
        middle = float(counts[-1]) - status.position
        jump = (self.calibration.middle - middle) * self.calibration.count
        self.calibration = replace(self.calibration, middle=middle)
        self.warmth.shift(jump)
        if self.interlock is not None:
            self.interlock.shift(jump)

    def _judge(self, samples: Samples, waiting: float) -> None:
        self.warmth.take(samples)
        if fault := fault_of(samples.status):  # the cause; what the interlock sees then may be its consequence
            raise fault
        if self.uno_clock.fault:
            raise RigFault(self.uno_clock.fault, "interlock")
        if self.interlock is not None:
            self.interlock.judge(samples, waiting)
            trip = self.interlock.estimate(self.warmth.estimate, float(samples.time[-1]), self.warmth.doubt)
            if trip:
                raise RigFault(f"the interlock stopped the rig: {trip}", "interlock")

    def _feed(self, samples: Samples) -> None:
        if self.player:
            self.player.take(samples)
        self._queue_command()  # before the Uno is asked for anything, as its line may be slow
        if self.player:
            try:
                self.player.feed(samples)
            except RigFault as refused:
                raise self._cause(refused) from None

    def _queue_command(self) -> None:
        if self._timed:
            ahead = (self.player.ahead if self.player else None) or self._ahead
            n = max(0, ahead - len(self._command))
            volts = self.player.voltage(self.queued, n) if self.player else np.zeros(n)
            if n > 0:
                factor = self.warmth.resistance if self.rig.supply.compensated else 1.0
                self.board.queue(self._checked(volts * factor) / self.rig.supply.gain)
                self._command = np.concatenate([self._command, volts])
                self._factors = np.concatenate([self._factors, np.full(n, factor)])

    def _checked(self, needed: Array) -> Array:
        """The coil's voltage, which drives the current that a cold coil would have, where the supply can give it."""
        supply = self.rig.supply
        if needed.max(initial=0.0) > supply.max_voltage * (1 + 1e-9):
            raise RigFault(
                f"the coil at {self.warmth.temperature:.0f} degC needs {needed.max():.3g} V, the supply gives "
                f"{supply.max_voltage:.3g} V; let the damper cool, or lower the test's voltage",
                "interlock",
            )
        return needed

    def play(self, drive: Drive) -> Player:
        """Play a drive from the first sample on whose command is not fixed yet."""
        # Without the lock: a path is interpolated and a kernel compiled, and blocks are read meanwhile.
        player = player_of(drive, self.rig, self.uno, self.uno_clock)
        with self.lock:
            # After a drive whose voltage was asked for late, less of it is queued than a drive needs to begin.
            player.start, self.player = max(self.queued, self._next + self._ahead if self._timed else 0), player
            return player

    def end_drive(self) -> None:
        """Nothing is played any more."""
        with self.lock:
            self.player = None

    def use(self, calibration: Calibration) -> None:
        """Use ``calibration`` from the next block on."""
        with self.lock:
            self.calibration = calibration

    def realign(self) -> None:
        """The board's counts are to be aligned with the Uno's by the next block."""
        with self.lock:
            self.aligned = False

    def home(self, here: bool) -> None:
        """Home the table where it stands, which is the middle, or begin to look for the index."""
        with self.lock:
            self._index.clear()
            if here:
                self.uno.disarm()
                self.uno.home(HERE, 0)
                self.uno.arm()
            else:
                self._index[0] = round(self.rig.encoder.index / self.rig.encoder.count)
                self.uno.home(INDEX, self._index[0])
            self.aligned = False  # the Uno may be homed anew between two blocks

    def settle(self, seconds: float = SETTLED) -> None:
        """Keep reading until the table is at rest, for ``seconds`` at most."""
        n = max(1, self.rig.block_samples // 4)
        for _ in range(math.ceil(seconds * self.rig.board.rate / n)):
            if self.stopped or self.cycle(n).status.speed == 0:
                return

    def halt(self, why: RigFault) -> RigFault:
        """Take the coil to 0 V and brake the table, now; every step is tried whatever fails. The first reason is kept.

        The coil comes first: it needs no serial wire, on which a request may wait for a reply that never comes.
        """
        with self.lock:
            self.stopped = self.stopped or why
            self.player = None
            for step in (self.cut, self.uno.abort):
                try:
                    step()
                except Exception as problem:  # whatever it is, the next step is tried
                    self.stopped.add_note(str(problem))
            return self.stopped

    def reason(self, refused: RigFault) -> RigFault:
        """What has stopped the rig, which is why a request was refused; ``refused`` where nothing has."""
        return self.stopped or self._cause(refused)

    def _cause(self, refused: RigFault) -> RigFault:
        """The fault for which the Uno refused a request, which the status of the last block did not show yet; else ``refused``.

        An Uno that did not answer is not asked again: its silence must not delay the way to rest.
        """
        if refused.ring != "firmware":
            return refused
        with suppress(RigFault), self.lock:
            return fault_of(self.uno.heartbeat()) or refused
        return refused

    def cut(self) -> None:
        """The coil to 0 V."""
        with self.lock:
            self._timed, self._command, self._factors = False, np.zeros(0), np.zeros(0)
            self.board.write(0.0)

    def end(self) -> None:
        """Leave the thread; the board still samples."""
        self._over.set()
        if self._thread and self._thread is not threading.current_thread() and self._thread.is_alive():
            self._thread.join(timeout=5.0)
        self._thread = None
