"""Loop that reads, judges and feeds an armed rig: what one in this process and one in another process offer alike."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, suppress
from typing import Any, Protocol

from dampyr.errors import RigFault
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.protocol import Status
from dampyr.rig.interlock import Samples
from dampyr.rig.player import Player
from dampyr.rig.uno_clock import ClockRatio

SETTLED = 0.3  # s in which a table that decelerates is at rest
SILENT = 30.0  # s without a block, after which none will come: the board itself gives an error within two
HELD = 10.0  # s of blocks that may wait to be stored: longer than a slow disk's pauses


class Loop(Protocol):
    """Blocks of samples from an armed rig; :class:`RigFault` is raised where a safety layer has acted.

    ``calibration`` is the one in use, ``status`` the Uno's with the last block, ``stopped`` what has stopped the rig. Requests
    of the Uno that belong together are made under ``lock``.
    """

    calibration: Calibration
    status: Status
    stopped: RigFault | None

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """Held while a block is judged and fed."""

    @property
    def next(self) -> int:
        """The next sample that will be read."""

    @property
    def clock_ratio(self) -> ClockRatio:
        """The Uno's clock against the board's, as far as it is known."""

    @property
    def index(self) -> Mapping[int, int]:
        """Where the encoder's index is passed, counts from the middle; see `Interlock`."""

    def begin(self) -> None:
        """Start sampling with the coil at 0 V; the board counts from 0, wherever the table stands."""

    def blocks(self) -> Iterator[Samples]:
        """Blocks as they arrive, without end."""

    def play(self, drive: Drive) -> Player:
        """Play a drive from the first sample on whose command is not fixed yet."""

    def end_drive(self) -> None:
        """Nothing is played any more."""

    def use(self, calibration: Calibration) -> None:
        """Use ``calibration`` from the next block on."""

    def realign(self) -> None:
        """The board's counts are to be aligned with the Uno's by the next block."""

    def home(self, here: bool) -> None:
        """Home the table where it stands, which is the middle, or begin to look for the index."""

    def settle(self, seconds: float = SETTLED) -> None:
        """Keep reading until the table is at rest, for ``seconds`` at most."""

    def halt(self, why: RigFault) -> RigFault:
        """Take the coil to 0 V and brake the table, now; from any thread. The first reason is kept, and returned."""

    def reason(self, refused: RigFault) -> RigFault:
        """What has stopped the rig, which is why a request was refused; ``refused`` where nothing has."""

    def cut(self) -> None:
        """The coil to 0 V."""

    def end(self) -> None:
        """End the loop; the board still samples."""


class WaitingBlocks:
    """Blocks of ``block`` [s] that wait for who reads them, and behind them the fault that has stopped the rig.

    ``halt`` is called where nobody reads them for `HELD`, or none comes for `SILENT`.
    """

    def __init__(self, block: float, halt: Callable[[RigFault], RigFault]) -> None:
        self._queue: queue.Queue[Samples | RigFault] = queue.Queue(max(4, round(HELD / block)))
        self._halt = halt

    def __len__(self) -> int:
        return self._queue.qsize()

    def put(self, samples: Samples) -> None:
        """A block has been read."""
        try:
            self._queue.put_nowait(samples)
        except queue.Full:
            self._halt(RigFault(f"blocks waited for {HELD:g} s to be stored; is the disk too slow?", "interlock"))

    def stop(self, fault: RigFault) -> None:
        """No block will come any more; whoever does not read finds ``stopped`` of the loop."""
        with suppress(queue.Full):
            self._queue.put_nowait(fault)

    def poll(self, seconds: float) -> Samples | RigFault | None:
        """The next block or fault; None where none comes within ``seconds``."""
        try:
            return self._queue.get(timeout=seconds)
        except queue.Empty:
            return None

    def take(self) -> Samples:
        """The next block; raises the fault."""
        block = self.poll(SILENT)
        if block is None:
            raise self._halt(RigFault(f"the rig gave no samples for {SILENT:g} s; is the board still there?"))
        if isinstance(block, RigFault):
            raise block
        return block
