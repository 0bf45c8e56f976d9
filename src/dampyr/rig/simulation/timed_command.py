"""The command voltage on the sample clock: one value a sample, put out when its sample is taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.simulation.board import BoardError
from dampyr.rig.simulation.simulator import Simulator

Array = NDArray[np.float64]
UNDERFLOW = -200290  # DAQmx: the generation ran out of samples


class TimedCommand:
    """A buffer of volts that a simulated rig puts out while it is read."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator
        self.values: Array | None = None
        self.played, self.start, self.period = 0, 0.0, 1.0

    def begin(self, rate: float, ahead: Array) -> None:
        """Put out ``ahead`` and what is queued after it, from the first sample of the task on."""
        self.values, self.played = np.array(ahead, float), 0
        self.start, self.period = self.simulator.time, 1.0 / rate

    def queue(self, volts: Array) -> None:
        """Append."""
        if self.values is None:
            raise BoardError(UNDERFLOW)
        self.values = np.concatenate([self.values, volts])

    def end(self) -> None:
        """Put out nothing more; the last value stays."""
        self.values = None

    def play(self, n: int) -> None:
        """Move the clock on by n samples, and put out each value in its time; runs of one value in one go."""
        if self.values is None:
            return
        if n > self.values.size:
            raise BoardError(UNDERFLOW)
        now, self.values = self.values[:n], self.values[n:]
        changes = np.flatnonzero(np.diff(now, prepend=np.nan))
        for k in changes:
            if now[k] != self.simulator.command:
                self.simulator.advance_to(self.start + (self.played + int(k) + 1) * self.period)
                self.simulator.write(float(now[k]))
        self.played += n
