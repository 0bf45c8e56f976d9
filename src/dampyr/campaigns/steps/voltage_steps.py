r"""Voltage steps: a steady sine while the coil's voltage jumps from level to level; how fast force follows voltage.

.. math:: x = A \sin 2 \pi f t, \qquad u = u_1, u_2, \ldots \text{ for } hold \text{ seconds each}

The sine is tapered as in `sine`; the voltage is 0 before the first level and after the last. For a response time choose
``hold`` so that jumps meet the sine at high speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, pi
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import around, stepwise, swing
from dampyr.campaigns.step import (
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
class VoltageSteps:
    """A sine with a staircase of voltages."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    frequency: Annotated[float, Frequency, "cycles per second"]
    voltages: Annotated[tuple[float, ...], Volts, "voltages at the coil, in this order"]
    hold: Annotated[float, Time, "time at each level of the voltage"] = 5.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "frequency")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "voltages")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        enough_points(self.period, self.frequency)
        if not self.voltages:
            raise InputError("voltages is empty; give at least one level")

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil: the levels begin with the steady cycles."""
        cycles = ceil(len(self.voltages) * self.hold * self.frequency - 1e-9)
        pieces = around([swing(self.amplitude, self.frequency, cycles, 1)], 0.0, self.rest_before)
        begin = self.rest_before + 1 / self.frequency
        return stepwise(pieces, self.period, begin, self.voltages, self.hold)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and 2 pi f A."""
        return Peaks(self.amplitude, 2 * pi * self.frequency * self.amplitude)
