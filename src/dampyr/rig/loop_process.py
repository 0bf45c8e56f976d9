"""Rig in a process of its own: the host's end.

What reads, judges and feeds a rig must not wait for anything else: a slow disk, a page that plans, a collection of
garbage. So the instruments of a rig in real time belong to a process that does nothing else
(`dampyr.rig.loop_server`), and here are their stand-ins, which ask it. Where this process ends, whatever the reason, the
other one stops the table, takes the coil to 0 V and disarms.
"""

from __future__ import annotations

import queue
import secrets
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from concurrent.futures import TimeoutError as Late
from contextlib import suppress
from itertools import count
from multiprocessing.connection import Connection, Listener
from pathlib import Path
from typing import Any, cast

from dampyr.errors import DampyrError, InputError, RigFault
from dampyr.origin import OriginKind
from dampyr.rig.acquisition import HELD, SETTLED, Acquisition
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import Status
from dampyr.rig.instruments.contract import TableDrive
from dampyr.rig.interlock import Samples
from dampyr.rig.player import Player
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.instrument_ends import Simulation
from dampyr.rig.thermal_model import Warmth

START = 30.0  # s that the process may take to import what it needs on a busy machine
COMPILED = 600.0  # s in which a simulated rig is compiled on a slow machine, the first time
PATIENCE = 30.0  # s beyond which an answer will not come: the longest, a HELLO during a boot loader, takes 4 s
ENDED = (
    "the process that reads the rig has ended; the Uno stops the table and cuts the coil by itself: look at both, then "
    "connect again"
)


class Link:
    """The two connections to the process that reads a rig: one for questions, one for samples."""

    def __init__(self, questions: Connection, blocks: Connection) -> None:
        self._questions, self._blocks = questions, blocks
        self._numbers, self._lock, self._ended = count(), threading.Lock(), False
        self._waiting: dict[int, Future[Any]] = {}
        self.held = 0.0
        """s for which the clock of a simulated rig was held back, as of its last block."""
        self.on_block: Callable[[tuple[Any, ...]], None] = lambda _: None
        self._receiving = [
            threading.Thread(target=receive, name=f"rig {receive.__name__}", daemon=True)
            for receive in (self._answers, self._samples)
        ]
        for each in self._receiving:
            each.start()

    def ask(self, what: str, *given: Any, patience: float = PATIENCE) -> Any:
        """What the other process answers, within ``patience`` s; what it raises is raised here."""
        answer: Future[Any] = Future()
        with self._lock:
            if self._ended:
                raise RigFault(ENDED)
            number = next(self._numbers)
            self._waiting[number] = answer
            try:
                self._questions.send((number, what, given))
            except (OSError, ValueError) as problem:
                raise RigFault(ENDED) from problem
        try:
            return answer.result(patience)
        except Late:
            raise RigFault(f"the process that reads the rig does not answer ({what}, {patience:g} s)") from None

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
                    answer.set_exception(rebuilt(failure))
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
            self._ended = True
            waiting, self._waiting = self._waiting, {}
        for answer in waiting.values():
            answer.set_exception(RigFault(ENDED))
        self.on_block(("stopped", described(RigFault(ENDED))))

    def close(self) -> None:
        """Have the other process disarm what is armed, and end."""
        with suppress(RigFault):
            self.ask("close")
        self._join()
        for each in self._receiving:  # their connections have ended with the process
            each.join()
        for connection in (self._questions, self._blocks):
            connection.close()

    def _join(self) -> None:
        """Wait for the other process."""


class LoopProcess(Link):
    """A running ``python -m dampyr.rig.loop_server`` with the instruments at the wires of ``settings``, or those of a rig that
    it simulates.
    """

    def __init__(self, settings: RigSettings, simulation: Simulation | None = None) -> None:
        key = secrets.token_bytes(32)
        with tempfile.TemporaryDirectory(prefix="dampyr-loop-") as folder:
            address = None if sys.platform == "win32" else str(Path(folder) / "wire")
            with Listener(address, "AF_PIPE" if sys.platform == "win32" else "AF_UNIX", authkey=key) as listener:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "dampyr.rig.loop_server", str(listener.address)],
                    stdin=subprocess.PIPE,
                    start_new_session=True,  # a Ctrl-C is for this process, which then asks the other one to stop
                    creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
                )
                assert self._process.stdin is not None
                with suppress(BrokenPipeError), self._process.stdin:
                    self._process.stdin.write(key)
                super().__init__(*self._accepted(listener))
        try:
            self.ask("open", settings, simulation, patience=PATIENCE if simulation is None else COMPILED)
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def _accepted(self, listener: Listener) -> tuple[Connection, Connection]:
        """The two connections of the process that was started; :class:`RigFault` where it ends before it asks for them."""
        accepted: Future[tuple[Connection, Connection]] = Future()

        def accept() -> None:
            try:
                accepted.set_result((listener.accept(), listener.accept()))
            except Exception as problem:
                accepted.set_exception(problem)

        threading.Thread(target=accept, name="rig accept", daemon=True).start()
        until = time.monotonic() + START
        while True:
            with suppress(Late):
                return accepted.result(0.1)
            if self._process.poll() is not None or time.monotonic() > until:
                self._process.kill()
                self._process.wait()
                raise RigFault("the process that is to read the rig did not start; what it printed is above")

    def _join(self) -> None:
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def described(problem: BaseException) -> tuple[str, str, str, list[str]]:
    """An error as it goes from one process to the other: kind, message, ring, notes."""
    kind = "input" if isinstance(problem, InputError) else "rig" if isinstance(problem, RigFault) else "other"
    message = str(problem) if isinstance(problem, DampyrError) else f"{type(problem).__name__}: {problem}"
    return kind, message, getattr(problem, "ring", ""), list(getattr(problem, "__notes__", []))


def rebuilt(failure: tuple[str, str, str, list[str]]) -> DampyrError:
    """The error of the other process."""
    kind, message, ring, notes = failure
    problem: DampyrError = InputError(message)
    if kind != "input":
        problem = RigFault(message if kind == "rig" else f"the process that reads the rig failed: {message}", ring)
    for note in notes:
        problem.add_note(note)
    return problem


def rebuilt_fault(failure: tuple[str, str, str, list[str]]) -> RigFault:
    """What has stopped the loop of the other process."""
    problem = rebuilt(failure)
    assert isinstance(problem, RigFault)
    return problem


class StandIn:
    """An instrument of the other process: its methods by their names."""

    def __init__(self, process: Link, name: str) -> None:
        self._process, self._name = process, name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *given: self._process.ask(f"{self._name}.{name}", *given)

    def origin(self) -> OriginKind:
        """What the board says of its samples."""
        kind: OriginKind = self._process.ask("origin")
        return kind

    def close(self) -> None:
        """Nothing: the other process closes its instruments when it ends."""


class RemoteLoop(Acquisition):
    """The acquisition of the other process: its blocks come here, and what is asked of it goes there."""

    def __init__(
        self,
        process: Link,
        rig: RigSettings,
        uno: Any,
        board: Any,
        calibration: Calibration,
        interlocked: bool,
        warmth: Warmth,
        watchers: Sequence[Callable[[Samples], None]] = (),
    ) -> None:
        self.process, self.rig, self.uno, self.board = process, rig, uno, board
        self.calibration, self.warmth, self.watchers = calibration, warmth, watchers
        self.lock = threading.RLock()
        self.player = None
        self.stopped: RigFault | None = None
        self.waiting = queue.Queue(max(4, round(HELD / rig.board.block)))
        self.status: Status = process.ask("acquire", calibration, interlocked, warmth.state)
        process.on_block = self._take

    def _take(self, message: tuple[Any, ...]) -> None:
        """A message of the other process's loop."""
        what, *values = message
        if what == "stopped":
            self._stop(rebuilt_fault(values[0]))
            return
        samples, calibration, warm, finished, self.process.held = values
        self.status, self.warmth.state = samples.status, warm
        with self.lock:
            self.calibration = calibration
            if self.player is not None and self.player.start == finished:
                self.player.finished = True
        try:
            self.waiting.put_nowait(samples)
        except queue.Full:
            self.halt(RigFault(f"blocks waited for {HELD:g} s to be stored; is the disk too slow?", "interlock"))
        for watch in self.watchers:
            watch(samples)

    def _stop(self, why: RigFault) -> RigFault:
        with self.lock:
            self.stopped = self.stopped or why
        with suppress(queue.Full):
            self.waiting.put_nowait(self.stopped)
        return self.stopped

    def begin(self) -> None:
        """Start sampling with the coil at 0 V."""
        self.process.ask("begin")

    @property
    def next(self) -> int:
        """The next sample that will be read."""
        return int(self.process.ask("next"))

    @property
    def index(self) -> dict[int, int]:
        """Where the encoder's index is passed, counts from the middle."""
        places: dict[int, int] = self.process.ask("index")
        return places

    def blocks(self) -> Iterator[Samples]:
        """Blocks as they arrive, without end."""
        while True:
            if self.stopped:
                raise self.stopped
            yield self._waited()

    def play(self, drive: Drive) -> Player:
        """Play a drive from the first sample on whose command is not fixed yet."""
        with self.lock:  # a block that says that it has finished comes after it is there
            start = self.process.ask("play", drive)
            self.player = Player(drive, self.rig, self.uno, start)
            return self.player

    def end_drive(self) -> None:
        """Nothing is played any more."""
        with self.lock:
            self.player = None
        self.process.ask("end_drive")

    def use(self, calibration: Calibration) -> None:
        """Use ``calibration`` from the next block on."""
        with self.lock:
            self.calibration = self.process.ask("use", calibration)

    def realign(self) -> None:
        """The board's counts are to be aligned with the Uno's by the next block."""
        self.process.ask("realign")

    def home(self, here: bool) -> None:
        """Home the table where it stands, or look for the index."""
        self.process.ask("home", here)

    def settle(self, seconds: float = SETTLED) -> None:
        """Keep reading until the table is at rest, for ``seconds`` at most."""
        self.process.ask("settle", seconds)

    def halt(self, why: RigFault) -> RigFault:
        """Brake the table and take the coil to 0 V, now. The first reason is kept."""
        try:
            first = rebuilt_fault(self.process.ask("halt", described(why)))
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
                reason = self.process.ask("reason", described(refused))
                return refused if reason == described(refused) else self._stop(rebuilt_fault(reason))
        return self.stopped or refused

    def cut(self) -> None:
        """The coil to 0 V."""
        self.process.ask("cut")

    def end(self) -> None:
        """End the loop; the board still samples."""
        self.process.ask("end")


def remote_rig(
    link: Link,
    settings: RigSettings,
    folder: Path | None = None,
    simulated: bool = False,
) -> Rig:
    """The rig whose instruments are open at the other end of ``link``; closing it closes the link."""

    def loop(rig: Rig) -> RemoteLoop:
        assert rig.calibration is not None
        return RemoteLoop(
            link, rig.settings, rig.uno, rig.board, rig.calibration, rig.interlocked, rig.warmth, rig.watchers
        )

    uno, board = StandIn(link, "uno"), StandIn(link, "board")
    return Rig(
        settings,
        cast(TableDrive, uno),
        board,
        threaded=False,
        folder=folder,
        acquisition=loop,
        on_close=[link.close],
        damper_persists=not simulated,
        held=lambda: link.held,
        simulated=simulated,
    )
