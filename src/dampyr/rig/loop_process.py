"""Rig in a process of its own: the host's end.

What reads, judges and feeds a rig must not wait for anything else: a slow disk, a page that plans, a collection of
garbage. So the instruments of a rig in real time belong to a process that does nothing else
(`dampyr.rig.loop_server`), and here are their stand-ins, which ask it. Where this process ends, whatever the reason, the
other one stops the table, takes the coil to 0 V and disarms.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from concurrent.futures import TimeoutError as Late
from contextlib import suppress
from functools import partial
from itertools import count
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, cast

from dampyr.errors import RigFault
from dampyr.origin import OriginKind
from dampyr.processes import ChildProcess
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import Status
from dampyr.rig.instruments.contract import TableDrive
from dampyr.rig.interlock import Samples
from dampyr.rig.loop import SETTLED, WaitingBlocks
from dampyr.rig.loop_server import SentBlock, serve_rig
from dampyr.rig.player import Player
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.instrument_ends import Simulation
from dampyr.rig.uno_clock import ClockRatio

START = 60.0  # s that the process may take to import what it needs, and to connect, on a busy machine
COMPILED = 600.0  # s in which a simulated rig is compiled on a slow machine, the first time
PATIENCE = 30.0  # s beyond which an answer will not come: the longest, a HELLO during a boot loader, takes 4 s
NOT_STARTED = "the process that is to read the rig did not start; what it printed is above"
ENDED = (
    "the process that reads the rig has ended; the Uno stops the table and cuts the coil by itself: look at both, then "
    "connect again"
)


class Link:
    """The two connections to the process that reads a rig: one for questions, one for samples.

    A question is a number, a name (of a method of `dampyr.rig.loop_server.LoopServer`, or of its ``uno``, ``board`` or
    ``loop``) and arguments; an answer is that number, and a value or an error. Answers come in any order, so that an abort does
    not wait for what another thread has asked.
    """

    def __init__(self, questions: Connection, blocks: Connection, ended: str = ENDED) -> None:
        self._questions, self._blocks, self.ended = questions, blocks, ended
        self._numbers, self._lock, self._over = count(), threading.Lock(), False
        self._waiting: dict[int, Future[Any]] = {}
        self.held = 0.0
        """s for which the clock of a simulated rig was held back, as of its last block."""
        self.on_block: Callable[[SentBlock | RigFault], None] = lambda _: None
        self._receiving = [
            threading.Thread(target=receive, name=f"rig {receive.__name__}", daemon=True)
            for receive in (self._answers, self._samples)
        ]
        for thread in self._receiving:
            thread.start()

    def ask(self, name: str, *arguments: Any, patience: float = PATIENCE) -> Any:
        """What the other process answers, within ``patience`` s; what it raises is raised here."""
        answer: Future[Any] = Future()
        with self._lock:
            if self._over:
                raise RigFault(self.ended)
            number = next(self._numbers)
            self._waiting[number] = answer
            try:
                self._questions.send((number, name, arguments))
            except (OSError, ValueError) as problem:
                raise RigFault(self.ended) from problem
        try:
            return answer.result(patience)
        except Late:
            raise RigFault(f"the process that reads the rig does not answer ({name}, {patience:g} s)") from None

    def _answers(self) -> None:
        try:
            while True:
                number, failure, value = self._questions.recv()
                with self._lock:
                    answer = self._waiting.pop(number, None)
                if answer is None:  # the process ended meanwhile
                    continue
                if failure is None:
                    answer.set_result(value)
                else:
                    answer.set_exception(failure)
        except (EOFError, OSError):
            self._end()

    def _samples(self) -> None:
        try:
            while True:
                self.on_block(self._blocks.recv())
        except (EOFError, OSError):
            self._end()

    def _end(self) -> None:
        """The other process is gone: whoever waits is told."""
        with self._lock:
            self._over = True
            waiting, self._waiting = self._waiting, {}
        for answer in waiting.values():
            answer.set_exception(RigFault(self.ended))
        self.on_block(RigFault(self.ended))

    def close(self) -> None:
        """Have the other process disarm what is armed, and end."""
        with suppress(RigFault):
            self.ask("close")
        self._join()
        for thread in self._receiving:  # their connections have ended with the process
            thread.join()
        for connection in (self._questions, self._blocks):
            connection.close()

    def _join(self) -> None:
        """Wait for the other process."""


class LoopProcess(Link):
    """A running process with the instruments at the wires of ``settings``, or those of a rig that it simulates."""

    def __init__(self, settings: RigSettings, simulation: Simulation | None = None) -> None:
        self._process = ChildProcess(serve_rig, pipes=2)
        questions, blocks = self._process.connections
        super().__init__(questions, blocks, NOT_STARTED)
        try:
            self.ask("open", settings, simulation, patience=START if simulation is None else COMPILED)
        except BaseException:
            self.close()
            raise
        self.ended = ENDED

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def _join(self) -> None:
        if self._process.wait(PATIENCE) is None:
            self._process.kill()


class StandIn:
    """An instrument of the other process: its methods by their names."""

    def __init__(self, link: Link, name: str) -> None:
        self._link, self._name = link, name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *arguments: self._link.ask(f"{self._name}.{name}", *arguments)

    def origin(self) -> OriginKind:
        """What the board says of its samples."""
        kind: OriginKind = self._link.ask("origin")
        return kind

    def close(self) -> None:
        """Nothing: the other process closes its instruments when it ends."""


class RemoteLoop:
    """The `dampyr.rig.loop.Loop` of the other process: its blocks come here, and what is asked of it goes there."""

    def __init__(self, link: Link, rig: Rig) -> None:
        assert rig.calibration is not None
        self.link, self.rig, self.calibration = link, rig, rig.calibration
        self.lock = threading.RLock()
        self.player: Player | None = None
        self.stopped: RigFault | None = None
        self.clock_ratio = ClockRatio()
        self.waiting = WaitingBlocks(rig.settings.board.block, self.halt)
        self.status: Status = link.ask("acquire", rig.calibration, rig.interlocked, rig.warmth.state)
        link.on_block = self._take

    def _ask(self, name: str, *arguments: Any) -> Any:
        return self.link.ask(f"loop.{name}", *arguments)

    def _take(self, message: SentBlock | RigFault) -> None:
        """What the other process's loop has sent."""
        if isinstance(message, RigFault):
            self._stop(message)
            return
        samples = message.samples
        self.status, self.rig.warmth.state, self.link.held = samples.status, message.warmth, message.held
        self.clock_ratio = message.clock_ratio
        with self.lock:
            self.calibration = message.calibration
            if self.player is not None and self.player.start == message.finished:
                self.player.finished = True
        self.waiting.put(samples)
        for watch in self.rig.watchers:
            watch(samples)

    def _stop(self, why: RigFault) -> RigFault:
        with self.lock:
            self.stopped = self.stopped or why
        self.waiting.stop(self.stopped)
        return self.stopped

    @property
    def next(self) -> int:
        """The next sample that will be read."""
        return int(self._ask("next"))

    @property
    def index(self) -> dict[int, int]:
        """Where the encoder's index is passed, counts from the middle."""
        places: dict[int, int] = self._ask("index")
        return places

    def begin(self) -> None:
        """Start sampling with the coil at 0 V."""
        self._ask("begin")

    def blocks(self) -> Iterator[Samples]:
        """Blocks as they arrive, without end."""
        while True:
            if self.stopped:
                raise self.stopped
            yield self.waiting.take()

    def play(self, drive: Drive) -> Player:
        """Play a drive from the first sample on whose command is not fixed yet."""
        with self.lock:  # a block that says that it has finished comes after it is there
            self.player = Player(drive, self.rig.settings, self.rig.uno, self.link.ask("play", drive))
            return self.player

    def end_drive(self) -> None:
        """Nothing is played any more."""
        with self.lock:
            self.player = None
        self._ask("end_drive")

    def use(self, calibration: Calibration) -> None:
        """Use ``calibration`` from the next block on."""
        with self.lock:
            self._ask("use", calibration)
            self.calibration = calibration

    def realign(self) -> None:
        """The board's counts are to be aligned with the Uno's by the next block."""
        self._ask("realign")

    def home(self, here: bool) -> None:
        """Home the table where it stands, or look for the index."""
        self._ask("home", here)

    def settle(self, seconds: float = SETTLED) -> None:
        """Keep reading until the table is at rest, for ``seconds`` at most."""
        self._ask("settle", seconds)

    def halt(self, why: RigFault) -> RigFault:
        """Brake the table and take the coil to 0 V, now. The first reason is kept."""
        try:
            first: RigFault = self._ask("halt", why)
        except RigFault as problem:
            first = why
            first.add_note(str(problem))
        return self._stop(first)

    def reason(self, refused: RigFault) -> RigFault:
        """What has stopped the rig, which is why a request was refused; ``refused`` where nothing has.

        The other process is asked: its refusal may be here before its message that it has stopped.
        """
        if not self.stopped:
            with suppress(RigFault):  # one that has ended does not answer, which is what `refused` says
                reason = self._ask("reason", refused)
                return refused if str(reason) == str(refused) else self._stop(reason)
        return self.stopped or refused

    def cut(self) -> None:
        """The coil to 0 V."""
        self._ask("cut")

    def end(self) -> None:
        """End the loop; the board still samples."""
        self._ask("end")


def remote_rig(link: Link, settings: RigSettings, folder: Path | None = None, simulated: bool = False) -> Rig:
    """The rig whose instruments are open at the other end of ``link``; closing it closes the link."""
    return Rig(
        settings,
        cast(TableDrive, StandIn(link, "uno")),
        StandIn(link, "board"),
        threaded=False,
        folder=folder,
        make_loop=partial(RemoteLoop, link),
        on_close=[link.close],
        damper_persists=not simulated,
        held=lambda: link.held,
        simulated=simulated,
    )
