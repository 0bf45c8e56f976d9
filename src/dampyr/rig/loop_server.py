"""Process that reads, judges and feeds a rig, and does nothing else.

`dampyr.rig.loop_process` starts it and asks it. It ends when it is asked to, or when its host is gone: then it stops the table,
takes the coil to 0 V and disarms before.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from dampyr.errors import DampyrError, InputError, RigFault
from dampyr.origin import OriginKind
from dampyr.rig.acquisition import Acquisition
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import Status
from dampyr.rig.gc_control import disable_gc, freeze_objects
from dampyr.rig.instruments.connection import open_instruments
from dampyr.rig.instruments.contract import stated_origin
from dampyr.rig.interlock import Interlock, Samples
from dampyr.rig.priority import raise_priority
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.instrument_ends import Simulation, simulate_instruments
from dampyr.rig.simulation.real_time import RealTimeSimulator
from dampyr.rig.thermal_model import Warmth, WarmthState
from dampyr.rig.uno_clock import ClockRatio, UnoClock

Opener = Callable[[RigSettings], tuple[Any, Any]]
Clock = Callable[[], float]
ANSWERING = 4  # threads: an abort does not wait behind what another thread of the host has asked


@dataclass(frozen=True)
class SentBlock:
    """A block as it goes to the host, with the calibration that it was made with, and the damper's warmth and the ratio of the
    Uno's clock to the board's after it; ``finished`` is the first sample of a drive that has been played to its end, ``held`` s
    for which a simulated clock was held back.
    """

    samples: Samples
    calibration: Calibration
    warmth: WarmthState
    clock_ratio: ClockRatio
    finished: int | None
    held: float


class LoopServer:
    """The instruments of one rig, and the loop that reads them."""

    def __init__(
        self,
        questions: Connection,
        blocks: Connection,
        opener: Opener = open_instruments,
        clock: Clock = time.monotonic,
    ) -> None:
        self.questions, self.blocks, self.opener, self.clock = questions, blocks, opener, clock
        self.sending = threading.Lock()
        self.loop: Acquisition | None = None
        self.rig: RigSettings | None = None
        self.uno: Any = None
        self.index: dict[int, int] = {}
        self.uno_clock = UnoClock()
        self.board: Any = None
        self.simulator: RealTimeSimulator | None = None
        self.release_gc: Callable[[], None] = lambda: None

    def serve(self) -> None:
        """Answer until the host is gone or asks to close; then nothing is armed any more."""
        with ThreadPoolExecutor(ANSWERING, "answer") as pool:
            try:
                while True:
                    number, name, arguments = self.questions.recv()
                    if name == "close":
                        self._leave()
                        self._reply(number, None, None)
                        return
                    pool.submit(self._answer, number, name, arguments)
            except (EOFError, OSError):
                self._leave()

    def _answer(self, number: int, name: str, arguments: tuple[Any, ...]) -> None:
        try:
            value = self._do(name, *arguments)
            self._reply(number, None, as_sent(value) if isinstance(value, BaseException) else value)
        except BaseException as problem:  # told to the host, which decides
            self._reply(number, as_sent(problem), None)

    def _reply(self, number: int, failure: DampyrError | None, value: Any) -> None:
        with self.sending, suppress(OSError):
            self.questions.send((number, failure, value))

    def _do(self, name: str, *arguments: Any) -> Any:
        owner, _, name = name.rpartition(".")
        if not owner:
            return getattr(self, f"do_{name}")(*arguments)
        if owner == "loop":
            value = getattr(self._loop(), name)
            return value(*arguments) if callable(value) else value
        instrument = {"uno": self.uno, "board": self.board}[owner]
        with self.loop.lock if self.loop is not None and owner == "uno" else nullcontext():
            return getattr(instrument, name)(*arguments)

    def do_open(self, rig: RigSettings, simulation: Simulation | None = None) -> None:
        """Connect to the instruments, or simulate the rig, whose time passes here then."""
        self.rig = rig
        if simulation is None:
            self.uno, self.board = self.opener(rig)
        else:
            self.simulator = simulation.in_real_time()
            self.clock = self.simulator.clock
            self.uno, self.board = simulate_instruments(rig, self.simulator)
        self.release_gc = disable_gc()

    def do_origin(self) -> OriginKind:
        """What the board says of its samples."""
        return stated_origin(self.board).kind

    def do_acquire(self, calibration: Calibration, interlocked: bool, warm: WarmthState) -> Status:
        """Make a loop for a rig that is about to be armed; the Uno's status."""
        assert self.rig is not None
        self.rig = calibration.corrected(self.rig)
        freeze_objects()
        interlock = Interlock(self.rig, index=self.index) if interlocked else None
        warmth = Warmth(self.rig, self.rig.specimen.room)
        warmth.state = warm
        parts = (calibration, interlock, warmth)
        self.loop = Acquisition(self.rig, self.uno, self.board, *parts, True, (), self.clock, self.uno_clock)
        threading.Thread(target=self._send, args=(self.loop,), name="send", daemon=True).start()
        return self.loop.status

    def _send(self, loop: Acquisition) -> None:
        """Send blocks; they wait in the loop's queue where the host does not take them."""
        with suppress(OSError):  # the host is gone: `serve` sees it
            while not (loop.over and not loop.waiting):
                block: Samples | RigFault | None = loop.waiting.poll(0.05)
                if block is None and loop.stopped and not loop.reading and not loop.waiting:
                    block = loop.stopped  # the blocks before it had left no place for it
                if isinstance(block, RigFault):
                    self.blocks.send(as_sent(block))
                    return
                if block is None:
                    continue
                player = loop.player
                finished = player.start if player is not None and player.finished else None
                held = 0.0 if self.simulator is None else self.simulator.held
                self.blocks.send(
                    SentBlock(block, loop.calibration, loop.warmth.state, loop.clock_ratio, finished, held)
                )

    def do_play(self, drive: Drive) -> int:
        """Play a drive; the sample with which it begins."""
        return self._loop().play(drive).start

    def _loop(self) -> Acquisition:
        if self.loop is None:
            raise RigFault("the rig is not armed")
        return self.loop

    def _leave(self) -> None:
        """Whatever is armed comes to rest with the coil at 0 V; each step is tried whatever fails."""
        loop = self.loop
        steps: list[Any] = []
        if loop is not None and not loop.over:
            steps += [loop.cut, loop.end_drive, self.uno.stop, loop.end, loop.settle, self.uno.disarm]
        if self.board is not None:
            steps += [self.board.stop, self.board.close]
        if self.uno is not None:
            steps += [self.uno.close]
        if self.simulator is not None:
            steps += [self.simulator.close]
        steps += [self.release_gc]
        for step in steps:
            with suppress(Exception):
                step()


def as_sent(problem: BaseException) -> InputError | RigFault:
    """An error as it goes from one process to the other, which may not know the class that a driver of one's own raises."""
    sent: InputError | RigFault
    if isinstance(problem, InputError):
        sent = InputError(str(problem))
    elif isinstance(problem, RigFault):
        sent = RigFault(str(problem), problem.ring)
    else:
        message = str(problem) if isinstance(problem, DampyrError) else f"{type(problem).__name__}: {problem}"
        sent = RigFault(f"the process that reads the rig failed: {message}")
    for note in getattr(problem, "__notes__", []):
        sent.add_note(note)
    return sent


def serve_rig(questions: Connection, blocks: Connection) -> None:
    """Serve one host, in a process of its own."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):  # these are for the host, which asks for what it wants
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    import scipy.interpolate  # noqa: F401  # what a path needs: later, between two blocks, the Uno would find its host silent

    raise_priority()
    LoopServer(questions, blocks).serve()
