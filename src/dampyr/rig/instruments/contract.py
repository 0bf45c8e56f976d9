"""Contracts of a rig's instruments: what an acquisition, a drive of the table and a supply of the coil have to offer.

All raise :class:`~dampyr.errors.RigFault` with one sentence where something fails. A call may come from any thread, but no
instrument is called by two at once, except for `TableDrive.abort` and what writes the coil's voltage.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FileError
from dampyr.origin import NOT_STATED, Origin, as_origin
from dampyr.rig.firmware.protocol import Status
from dampyr.rig.settings import RigSettings

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
INDEX, HERE = 1, 0  # how to home


class AcquisitionBoard(Protocol):
    """An acquisition: the rig's analogue inputs and the encoder's position on one sample clock.

    That of a real instrument has ``origin()``, too, which gives "measured" (`stated_origin`). Where ``wires.shunt`` names a
    relay, it has ``shunt(on)``, which switches it at once, whatever is being read.
    """

    def start(self, rate: float, ahead: Array) -> None:
        """Start sampling at ``rate`` [Hz], the position counted from 0. The command, if it is an output of this board, begins
        with the volts in ``ahead``, one a sample; with none in it, the command is another instrument's.
        """

    def read(self, n: int) -> tuple[Array, Counts]:
        """The next n samples: volts (channels, n), in the order of the rig's ``inputs``, and counts (n,); waits for them."""

    def index_counts(self) -> Counts:
        """The counts (k,) at which the encoder's index was passed since the last call, hardware-latched; none without."""

    def stop(self) -> None:
        """Stop sampling; the command stays as it is."""

    def close(self) -> None:
        """Close the board."""

    def identity(self) -> str:
        """Product and serial number."""


class AnalogueOutput(Protocol):
    """A command on the sample clock, V: of an acquisition whose output drives the damper's supply."""

    def queue(self, volts: Array) -> None:
        """Append to the command, a sample of it per sample read."""

    def write(self, volts: float) -> None:
        """Set the command now; what was queued is dropped, and nothing is queued before the next start."""


class Board(AcquisitionBoard, AnalogueOutput, Protocol):
    """What the loop that reads a rig needs: an acquisition with the command."""


class CoilSupply(Protocol):
    """A supply without a sample clock, such as one on a bench: its voltage is set, and comes a while later."""

    latency: float
    """s from the call of `write` until the coil has the voltage, at most."""

    def write(self, volts: float) -> None:
        """Set the command [V]; returns at once, without waiting for the voltage."""

    def close(self) -> None:
        """Close the supply; its voltage stays."""

    def identity(self) -> str:
        """Product and serial number."""


@dataclass(frozen=True)
class Program:
    """What the firmware of an Uno was built with: the kind of bridge, the line's speed, the digest of its sources.

    ``up_to_date``: whether these are the sources of this dampyr. ``extended_fuse``: the chip's, with its brown-out level.
    """

    direction_pin: bool
    baud: int
    digest: str
    up_to_date: bool
    extended_fuse: int


@dataclass(frozen=True)
class Hello:
    """The identity that a drive reports: version of the protocol, firmware, control rate [Hz], set points in its queue.

    ``program``: of an Uno, what its firmware was built with; None of a drive that does not say.
    """

    version: int
    firmware: str
    rate: int
    queue: int
    program: Program | None = None


class TableDrive(Protocol):
    """A drive: the controller of the table's motor, with limits, watchdog and enable line of its own.

    Positions are in counts of the encoder from the middle. What each request does, and what a `Status` says, is in
    docs/reference/protocol.md, whose requests these are.
    """

    def hello(self) -> Hello:
        """Say hello."""

    def configure(self, rig: RigSettings) -> None:
        """Give the drive its limits, those of ``rig``."""

    def heartbeat(self) -> Status:
        """Send a heartbeat; the drive's status."""

    def arm(self) -> None:
        """Arm: enable line high."""

    def disarm(self) -> None:
        """Enable line low, motor shorted."""

    def home(self, how: int, counts: int) -> None:
        """Take the table to be at ``counts`` (`HERE`), or look for the index, which is there (`INDEX`)."""

    def jog(self, speed: int, time_ms: int) -> None:
        """Move at ``speed`` counts/s for a while, at most 500 ms."""

    def points(self, first: int, positions: list[int]) -> int:
        """Send set points [counts], numbered from ``first``; how many places are free then."""

    def follow(self, period_ms: int, n: int) -> None:
        """Follow the set points."""

    def reverse(self, duty: int, half_ms: int, pause_ms: int, n: int) -> None:
        """Constant duty whose sign changes every half period."""

    def stop(self) -> None:
        """Decelerate to rest."""

    def abort(self) -> None:
        """Brake and cut the coil, now."""

    def clear(self) -> None:
        """Leave FAULT."""

    def close(self) -> None:
        """Close the wire."""


def stated_origin(board: Any) -> Origin:
    """What the driver of an acquisition says of its samples by ``origin()``, which it may lack: "measured" of a real one."""
    return as_origin(board.origin()) if hasattr(board, "origin") else NOT_STATED


def check_offers(instrument: Any, contracts: tuple[type, ...], role: str, where: str) -> None:
    """Raise :class:`FileError` where ``instrument``, of the folder ``where``, lacks something of its ``contracts``."""
    names = [name for contract in contracts for name in [*vars(contract), *getattr(contract, "__annotations__", {})]]
    missing = [name for name in names if not name.startswith("_") and not hasattr(instrument, name)]
    if missing:
        lacks = " and ".join(f"no {name}{'' if name == 'latency' else '()'}" for name in dict.fromkeys(missing))
        raise FileError(
            where,
            f"its driver has {lacks}, which is needed of {'an' if role[0] in 'aeiou' else 'a'} {role}; "
            "dampyr help add-an-instrument lists what one has to offer",
        )
