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
LATE = 4  # blocks that may be waiting when one is read: at 40 ms each, the reaction stays under 0.2 s


@dataclass(frozen=True, eq=False)
class Samples:
    """One block on one clock: time s, displacement m, force N, temperature degC or None, volts and counts as read."""

    first: int
    time: Array
    displacement: Array
    force: Array
    temperature: Array | None
    volts: Array
    counts: NDArray[np.int64]
    voltage: Array
    status: Status

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
        words = f"{self.what} {self.value:.4g} {self.unit} passed {limit} at {self.time:.2f} s"
        return f"{words}; {self.look}" if self.look else words


@dataclass
class Interlock:
    """Checks blocks; ``trip`` is the first reason to stop."""

    rig: RigSettings
    trip: Trip | None = None
    _before: Array = field(default_factory=lambda: np.empty(0))

    def judge(self, samples: Samples, waiting: float = 0.0) -> Trip | None:
        """The first limit that a block leaves, or None; ``waiting`` is the age [s] of its last sample when it was read."""
        limits, time = self.rig.limits, float(samples.time[-1])
        speed = self._speed(samples)
        readings = [
            (np.abs(samples.volts[0]).max(), RAIL * self.rig.board.range, "load cell signal", "V", "look at its wire"),
            (np.abs(samples.force).max(), limits.force, "force", "N", "look at the specimen and the load cell"),
            (np.abs(samples.displacement).max(), limits.stroke / 2, "displacement", "m", "home the table"),
            (speed, limits.speed, "speed", "m/s", "look at the motor's drive"),
            (waiting, LATE * self.rig.board.block, "age of the samples", "s", "the host is too slow or was stopped"),
            (
                self._apart(samples, speed, waiting),
                APART,
                "distance of the board's and the Uno's position",
                "m",
                "look at the encoder",
            ),
        ]
        if samples.temperature is not None:
            hot = (samples.temperature.max(), limits.temperature, "temperature", "degC", "let the damper cool")
            readings.append(hot)
        for value, limit, what, unit, look in readings:
            if not value <= limit and self.trip is None:
                self.trip = Trip(what, float(value), float(limit), unit, time, look)
        return self.trip

    def estimate(self, temperature: float, time: float) -> Trip | None:
        """Check an estimated temperature [degC], where none is measured."""
        limit = self.rig.limits.temperature
        if not temperature <= limit and self.trip is None:
            self.trip = Trip("estimated temperature", temperature, limit, "degC", time, "let the damper cool")
        return self.trip

    def shift(self, jump: float) -> None:
        """The displacement is counted from elsewhere: it grew by ``jump`` [m] and the table did not move."""
        self._before = self._before + jump

    def _speed(self, samples: Samples) -> float:
        """The largest speed over `WINDOW`, across the border to the block before."""
        lag = max(1, round(WINDOW * self.rig.board.rate))
        path = np.concatenate([self._before, samples.displacement])
        self._before = path[-lag:]
        return float(np.abs(path[lag:] - path[:-lag]).max(initial=0.0)) * self.rig.board.rate / lag

    def _apart(self, samples: Samples, speed: float, waiting: float) -> float:
        """How far the board's last position is from the Uno's, asked ``waiting`` s later and up to a block more: a late
        host is no fault of the encoder's, and its lateness has a limit of its own.
        """
        if not samples.status.homed:
            return 0.0
        count = self.rig.encoder.count
        now = abs(samples.status.speed) * count
        moved = now * self.rig.board.block + max(now, speed) * waiting
        return max(0.0, abs(float(samples.displacement[-1]) - samples.status.position * count) - moved)
