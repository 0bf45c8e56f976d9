"""Command voltage on the sample clock: one value a sample, output when its sample is taken."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class TimedCommand:
    """A buffer of volts; value k is output at ``start`` + (k + 1)*``period`` [s] and held."""

    def __init__(self, start: float, rate: float, ahead: Array) -> None:
        self.start, self.period = start, 1.0 / rate
        self.values: Array = np.array(ahead, float)
        self.dropped = 0  # values that were output and dropped

    def queue(self, volts: Array) -> None:
        """Append."""
        self.values = np.concatenate([self.values, volts])

    def _count(self, time: float) -> int:
        """The number of values of the buffer that are output by ``time``."""
        return max(0, math.floor((time - self.start) / self.period + 1e-6) - self.dropped)

    def empty(self, time: float) -> bool:
        """Whether the generation has run out of values."""
        return self._count(time) > self.values.size

    def held(self, time: float) -> int:
        """The number of values that are not output by ``time``."""
        return max(0, self.values.size - self._count(time))

    def due(self, time: float) -> float | None:
        """The value that is output at ``time``; None before the first."""
        count = min(self._count(time), self.values.size)
        if count == 0:
            return None
        value = float(self.values[count - 1])
        self.values, self.dropped = self.values[count - 1 :], self.dropped + count - 1
        return value

    def next_change(self, time: float, held: float) -> float:
        """The time at which the next value that differs from ``held`` is output; infinity where there is none."""
        count = self._count(time)
        differing = np.flatnonzero(self.values[count:] != held)
        return self.start + (self.dropped + count + int(differing[0]) + 1) * self.period if differing.size else math.inf
