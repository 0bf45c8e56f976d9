r"""Random voltage: a steady sine while the coil's voltage is drawn anew every ``hold`` seconds; for models under control.

.. math:: x = A \sin 2 \pi f t, \qquad u \sim \mathrm{U}(low, high) \text{ by the seed, held for } hold \text{ seconds}

The sine is tapered as in `sine`; the voltage is 0 during the taper. A semi-active controller switches like this, and models
that are right at constant voltages need not be right here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, pi
from typing import Annotated, ClassVar

import numpy as np

from dampyr.campaigns.paths import around, stepwise, swing
from dampyr.campaigns.step import (
    Count,
    Frequency,
    Length,
    Peaks,
    Period,
    Rest,
    Time,
    Volts,
    check_ranges,
    enough_points,
)
from dampyr.errors import InputError
from dampyr.rig import Drive, RigSettings


@dataclass(frozen=True)
class RandomVoltage:
    """A sine with random levels of voltage."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    frequency: Annotated[float, Frequency, "cycles per second"]
    high: Annotated[float, Volts, "highest voltage at the coil"]
    low: Annotated[float, Volts, "lowest voltage at the coil"] = 0.0
    hold: Annotated[float, Time, "time at each level of the voltage"] = 0.25
    cycles: Annotated[int, Count, "number of steady cycles"] = 20
    seed: Annotated[int, "seed of the levels"] = 0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "high")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "low", "high", "seed")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.seed < 0:
            raise InputError(f"seed = {self.seed} is not allowed; it must be at least 0")
        enough_points(self.period, self.frequency)
        if self.low > self.high:
            raise InputError(f"low = {self.low:g} V is above high = {self.high:g} V; exchange them")
        if self.hold < self.period:
            raise InputError(f"hold = {self.hold:g} s is shorter than period = {self.period:g} s; hold longer")

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil: the levels begin and end with the steady cycles."""
        pieces = around([swing(self.amplitude, self.frequency, self.cycles, 1)], 0.0, self.rest_before)
        steady = self.cycles / self.frequency
        count = max(1, ceil(steady / self.hold - 1e-9))
        levels = self.low + (self.high - self.low) * np.random.default_rng(self.seed).uniform(size=count)
        return stepwise(pieces, self.period, self.rest_before + 1 / self.frequency, [*levels], self.hold)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and 2 pi f A."""
        return Peaks(self.amplitude, 2 * pi * self.frequency * self.amplitude)
