"""Process that reads, judges and feeds a rig, and does nothing else: ``python -m dampyr.rig.loop_server ADDRESS``.

`dampyr.rig.loop_process` starts it and asks it; the key of the connection comes on the standard input. It ends when it is
asked to, or when its host is gone: then it stops the table, takes the coil to 0 V and disarms before.
"""

from __future__ import annotations

import queue
import signal
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from multiprocessing.connection import Client, Connection
from typing import Any

from dampyr.errors import RigFault
from dampyr.origin import OriginKind
from dampyr.rig.acquisition import SETTLED, Acquisition
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import Status
from dampyr.rig.gc_control import disable_gc, freeze_objects
from dampyr.rig.instruments.connection import open_instruments
from dampyr.rig.instruments.contract import stated_origin
from dampyr.rig.interlock import Interlock
from dampyr.rig.loop_process import described, rebuilt_fault
from dampyr.rig.priority import raise_priority
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.instrument_ends import Simulation, simulate_instruments
from dampyr.rig.simulation.real_time import RealTimeSimulator
from dampyr.rig.thermal_model import Warmth, WarmthState

Opener = Callable[[RigSettings], tuple[Any, Any]]
Clock = Callable[[], float]
ANSWERING = 4  # threads: an abort does not wait behind what another thread of the host has asked


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
        self.board: Any = None
        self.simulator: RealTimeSimulator | None = None
        self.release_gc: Callable[[], None] = lambda: None

    def serve(self) -> None:
        """Answer until the host is gone or asks to close; then nothing is armed any more."""
        with ThreadPoolExecutor(ANSWERING, "answer") as pool:
            try:
                while True:
                    number, what, given = self.questions.recv()
                    if what == "close":
                        self._leave()
                        self._reply(number, None, None)
                        return
                    pool.submit(self._answer, number, what, given)
            except (EOFError, OSError):
                self._leave()

    def _answer(self, number: int, what: str, given: tuple[Any, ...]) -> None:
        try:
            value = self._do(what, *given)
        except BaseException as problem:  # told to the host, which decides
            self._reply(number, described(problem), None)
        else:
            self._reply(number, None, value)

    def _reply(self, number: int, failure: Any, value: Any) -> None:
        with self.sending, suppress(OSError):
            self.questions.send((number, failure, value))

    def _do(self, what: str, *given: Any) -> Any:
        owner, _, name = what.partition(".")
        if name:
            instrument = {"uno": self.uno, "board": self.board}[owner]
            with self.loop.lock if self.loop is not None and owner == "uno" else threading.Lock():
                return getattr(instrument, name)(*given)
        return getattr(self, f"do_{what}")(*given)

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
        self.loop = Acquisition(self.rig, self.uno, self.board, calibration, interlock, warmth, True, (), self.clock)
        return self.loop.status

    def do_begin(self) -> None:
        """Start sampling, and sending what is read."""
        loop = self._loop()
        loop.begin()
        threading.Thread(target=self._send, args=(loop,), name="send", daemon=True).start()

    def _send(self, loop: Acquisition) -> None:
        """Send blocks; they wait in the loop's queue where the host does not take them."""
        with suppress(OSError):  # the host is gone: `serve` sees it
            while not (loop.over and loop.waiting.empty()):
                try:
                    block = loop.waiting.get(timeout=0.05)
                except queue.Empty:
                    continue
                if isinstance(block, RigFault):
                    self.blocks.send(("stopped", described(block)))
                    return
                player = loop.player
                finished = player.start if player is not None and player.finished else None
                held = 0.0 if self.simulator is None else self.simulator.held
                self.blocks.send(("block", block, loop.calibration, loop.warmth.state, finished, held))

    def do_next(self) -> int:
        """The next sample that will be read."""
        return self._loop().next

    def do_index(self) -> dict[int, int]:
        """Where the encoder's index is passed."""
        return dict(self._loop().index)

    def do_play(self, drive: Drive) -> int:
        """Play a drive; the sample with which it begins."""
        return self._loop().play(drive).start

    def do_end_drive(self) -> None:
        """Play nothing any more."""
        self._loop().end_drive()

    def do_use(self, calibration: Calibration) -> Calibration:
        """Use a calibration from the next block on."""
        self._loop().use(calibration)
        return self._loop().calibration

    def do_realign(self) -> None:
        """Align the board's counts with the Uno's by the next block."""
        self._loop().realign()

    def do_home(self, here: bool) -> None:
        """Home the table where it stands, or look for the index."""
        self._loop().home(here)

    def do_settle(self, seconds: float) -> None:
        """Read until the table is at rest."""
        self._loop().settle(seconds)

    def do_halt(self, why: tuple[str, str, str, list[str]]) -> tuple[str, str, str, list[str]]:
        """Brake and cut; the first reason."""
        return described(self._loop().halt(rebuilt_fault(why)))

    def do_reason(self, refused: tuple[str, str, str, list[str]]) -> tuple[str, str, str, list[str]]:
        """What has stopped the rig, which is why a request was refused; ``refused`` where nothing has."""
        return described(self._loop().reason(rebuilt_fault(refused)))

    def do_cut(self) -> None:
        """The coil to 0 V."""
        self._loop().cut()

    def do_end(self) -> None:
        """End the loop."""
        self._loop().end()

    def _loop(self) -> Acquisition:
        if self.loop is None:
            raise RigFault("the rig is not armed")
        return self.loop

    def _leave(self) -> None:
        """Whatever is armed comes to rest with the coil at 0 V; each step is tried whatever fails."""
        loop = self.loop
        steps: list[Any] = []
        if loop is not None and not loop.over:
            steps += [loop.cut, loop.end_drive, self.uno.stop, loop.end, lambda: loop.settle(SETTLED), self.uno.disarm]
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


def main() -> int:
    """Serve one host."""
    for each in ("SIGINT", "SIGTERM", "SIGHUP"):  # these are for the host, which asks for what it wants
        if hasattr(signal, each):
            signal.signal(getattr(signal, each), signal.SIG_IGN)
    raise_priority()
    address, key = sys.argv[1], sys.stdin.buffer.read()
    with Client(address, authkey=key) as questions, Client(address, authkey=key) as blocks:
        LoopServer(questions, blocks).serve()
    return 0


if __name__ == "__main__":
    sys.exit(main())
