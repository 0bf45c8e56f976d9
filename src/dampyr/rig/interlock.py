"""Interlock, the second safety layer: every block of samples is checked before anything else is done with it.

It depends neither on the firmware's own limits (layer 1) nor on the campaign's check before motion (layer 3).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.firmware.protocol import Status
from dampyr.rig.settings import RigSettings

Array = NDArray[np.float64]
RAIL = 0.995  # of the board's range: a broken wire drives an amplifier against it
APART = 1.0e-3  # m, by which the board's and the Uno's positions may differ
WINDOW = 0.010  # s, over which a speed is taken
UNHOMED_SPEED = 0.008  # m/s while the table may only go slowly: the Uno's own limit is 5 mm/s, without a block's delay
UNHOMED_FORCE = 1500.0  # N while it is not homed: the Uno pushes with 800 N at most against the damper's stop
UNHOMED_SPARE = 0.002  # m beyond a stroke that a search for the index may go
OUTWARD = 2e-4  # m that a table outside of its limits may go farther out
REST_APART = 2  # counts by which board and Uno may differ at rest, and by which the index may be passed off its place
MARK_WIDTH = 6  # counts between the two edges of an index mark, at most: a line of the encoder has 4
LATE = 4  # blocks that may be waiting when one is read: at 40 ms each, the reaction stays under 0.2 s


@dataclass(frozen=True, eq=False)
class Samples:
    """One block on one clock: time s, displacement m, force N, temperature degC or None, volts (channels, n) and counts as
    read; ``voltage`` V is that of a coil at 20 degC, read back where the rig reads it, else as commanded.
    """

    first: int
    time: Array
    displacement: Array
    force: Array
    temperature: Array | None
    volts: Array
    counts: NDArray[np.int64]
    voltage: Array
    status: Status
    index: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    """Counts from the middle at which the board has seen the encoder's index in this block."""
    command: Array = field(default_factory=lambda: np.empty(0))
    """The command [V at the coil] that was output: `voltage` as asked for, more by the warmth of the coil."""
    target: Array | None = None
    """The position [m] that a drive asks for, nan before and after it; None where none is played that asks for positions."""
    asked: Array = field(default_factory=lambda: np.empty(0))
    """The voltage [V] that was asked for, of a coil at 20 degC."""

    @property
    def n(self) -> int:
        """The number of samples."""
        return int(self.time.size)


@dataclass(frozen=True)
class Trip:
    """The reason why the interlock stopped the rig: quantity, value and limit (SI), and time [s]."""

    what: str
    value: float
    limit: float
    unit: str
    time: float
    look: str = ""

    def __str__(self) -> str:
        limit = f"its limit of {self.limit:.4g} {self.unit}"
        sentence = f"{self.what} {self.value:.4g} {self.unit} passed {limit} at {self.time:.2f} s"
        return f"{sentence}; {self.look}" if self.look else sentence


@dataclass
class Interlock:
    """Checks blocks; ``trip`` is the first reason to stop.

    ``index``: where the encoder's index is passed, counts from the middle: under 0 as homing put it, under 1 and 2 as the board
    has latched it. It latches the rising edge of a mark that is wider than a count, so that there are two, one a direction.
    """

    rig: RigSettings
    trip: Trip | None = None
    index: dict[int, int] = field(default_factory=dict)
    _still: bool = False
    _edge: float | None = None
    _before: Array = field(default_factory=lambda: np.empty(0))

    def judge(self, samples: Samples, waiting: float = 0.0) -> Trip | None:
        """The first limit that a block leaves, or None; ``waiting`` is the age [s] of its last sample when it was read."""
        limits, time = self.rig.limits, float(samples.time[-1])
        speed, homed = self._speed(samples), samples.status.homed
        slow = not homed or self._edge is not None or samples.status.outside
        force = limits.force if homed else min(limits.force, UNHOMED_FORCE)
        fastest = min(limits.speed, UNHOMED_SPEED) if slow else limits.speed
        readings = [
            (np.abs(samples.volts[0]).max(), RAIL * self.rig.board.range, "load cell signal", "V", "look at its wire"),
            (np.abs(samples.force).max(), force, "force", "N", "look at the specimen and the load cell"),
            (np.abs(samples.displacement).max(), self._farthest(samples), "displacement", "m", "home the table"),
            (speed, fastest, "speed", "m/s", "look at the motor's drive"),
            (waiting, LATE * self.rig.board.block, "age of the samples", "s", "the host is too slow or was stopped"),
            (
                self._position_difference(samples, speed, waiting),
                APART,
                "distance of the board's and the Uno's position",
                "m",
                "look at the encoder",
            ),
            (
                self._difference_at_rest(samples),
                REST_APART,
                "distance of the board's and the Uno's position at rest",
                "counts",
                "look at the encoder's wires to both",
            ),
            (
                self._index_shift(samples),
                REST_APART,
                "shift of the encoder's index",
                "counts",
                "counts were lost, or its scale slipped: look at the encoder, and home the table again",
            ),
        ]
        if samples.temperature is not None:
            hot = (samples.temperature.max(), limits.temperature, "temperature", "degC", "let the damper cool")
            readings.append(hot)
        for value, limit, what, unit, look in readings:
            if not value <= limit and self.trip is None:  # so written, a value that is not a number stops the rig too
                self.trip = Trip(what, float(value), float(limit), unit, time, look)
        return self.trip

    def estimate(self, temperature: float, time: float, doubt: str = "") -> Trip | None:
        """Check an estimated temperature [degC], measured or not: a thermocouple that is stuck does not guard. ``doubt`` is
        what seems to be wrong with its reading.
        """
        limit = self.rig.limits.temperature
        if not temperature <= limit and self.trip is None:
            look = "; ".join(filter(None, ("let the damper cool", doubt)))
            self.trip = Trip("estimated temperature", temperature, limit, "degC", time, look)
        return self.trip

    def shift(self, jump: float) -> None:
        """The displacement is counted from elsewhere: it grew by ``jump`` [m] and the table did not move."""
        self._before = self._before + jump

    def _farthest(self, samples: Samples) -> float:
        """m from the middle to which the table may be: the travel, where it stood if that is outside of it, or, while it is
        not homed, a stroke from where it was armed.
        """
        if not samples.status.homed:
            return self.rig.limits.stroke + UNHOMED_SPARE
        edge = self._edge
        if samples.status.outside and edge is None:
            edge = float(np.abs(samples.displacement).max()) + OUTWARD
        self._edge = edge if samples.status.outside else None
        return max(self.rig.travel, edge or 0.0)

    def _difference_at_rest(self, samples: Samples) -> float:
        """Counts by which board and Uno differ where the table stands for the second block on end; else 0."""
        still = samples.status.speed == 0 and int(np.ptp(samples.counts)) == 0
        before, self._still = self._still, still
        if not (before and still and samples.status.homed):
            return 0.0
        # A displacement is that of the middle of its count.
        return abs(round(float(samples.displacement[-1]) / self.rig.encoder.count - 0.5) - samples.status.position)

    def _index_shift(self, samples: Samples) -> float:
        """Counts by which the index was off its place in this block, at most.

        Its mark has two edges, one for each direction of the table: the first two places near that of homing are theirs.
        """
        worst = 0.0
        for place in samples.index.tolist():
            near = abs(place - self.index.setdefault(0, place)) <= MARK_WIDTH
            edges = [value for key, value in self.index.items() if key]
            shift = min((abs(place - edge) for edge in edges), default=MARK_WIDTH + 1)
            if shift > REST_APART and near and len(edges) < 2:
                self.index[len(edges) + 1] = place
            else:
                worst = max(worst, shift if near else abs(place - self.index[0]))
        return worst

    def _speed(self, samples: Samples) -> float:
        """The largest speed over `WINDOW`, across the border to the block before."""
        lag = max(1, round(WINDOW * self.rig.board.rate))
        path = np.concatenate([self._before, samples.displacement])
        self._before = path[-lag:]
        return float(np.abs(path[lag:] - path[:-lag]).max(initial=0.0)) * self.rig.board.rate / lag

    def _position_difference(self, samples: Samples, speed: float, waiting: float) -> float:
        """How far the board's last position is from the Uno's, asked ``waiting`` s later and up to a block more, less the way
        in that time: a late host is not a fault of the encoder, and its lateness has a limit of its own.
        """
        if not samples.status.homed:
            return 0.0
        count = self.rig.encoder.count
        speed_now = abs(samples.status.speed) * count
        moved = speed_now * self.rig.board.block + max(speed_now, speed) * waiting
        return max(0.0, abs(float(samples.displacement[-1]) - samples.status.position * count) - moved)
