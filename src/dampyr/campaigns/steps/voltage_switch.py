r"""Voltage switch: strokes at a constant speed, the coil's voltage switched within a stroke; the response time of the force.

.. math:: |\dot x| = v \text{ between } -A \text{ and } A, \qquad u = u_0 \leftrightarrow u_1

A round has six strokes: it rises in an extension, falls in the compression after it and stays low for a stroke; then it
rises in a compression and falls in the extension after it. So it rises and falls once in either direction, each time after
``share`` of the stroke's time, and the rest of the stroke is left to the force.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from dampyr.campaigns.paths import RAMP, around, move, moves, sampled, top_speed
from dampyr.campaigns.step import Count, Length, Peaks, Period, Rest, Speed, Volts, check_ranges
from dampyr.errors import InputError
from dampyr.rig import Drive, RigSettings
from dampyr.units import Quantity

STROKES = (
    6  # of a round; it is high from the switch in the first to that in the second, and from the fourth to the fifth
)
SWITCHES = ((0, True), (1, False), (3, True), (4, False))


@dataclass(frozen=True)
class VoltageSwitch:
    """A triangle with a voltage that is switched within its strokes."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    speed: Annotated[float, Speed, "speed between the turns"]
    high: Annotated[float, Volts, "voltage at the coil after a rise"]
    low: Annotated[float, Volts, "voltage at the coil before a rise"] = 0.0
    rounds: Annotated[
        int, Count, "number of rounds of six strokes, each with a rise and a fall in either direction"
    ] = 1
    share: Annotated[float, Quantity("", low=0.1, high=0.8), "share of a stroke's time before the switch"] = 0.35
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "speed")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "speed", "low", "high")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True
    role: ClassVar[str] = "validation"  # a voltage that jumps in a stroke is nothing that a law is fitted to

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.low < self.high:
            raise InputError(f"high = {self.high:g} V must be above low = {self.low:g} V; exchange the two")
        if self.speed * 2 * RAMP > 2 * self.amplitude:
            raise InputError(
                f"amplitude = {1e3 * self.amplitude:g} mm is too short for {1e3 * self.speed:g} mm/s to be held at all; give "
                f"more than {1e3 * self.speed * RAMP:.3g} mm, or a lower speed"
            )

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        turns = [-self.amplitude, self.amplitude] * (STROKES // 2 * self.rounds) + [-self.amplitude]
        x = sampled(around(list(moves([0.0, *turns, 0.0], self.speed)), 0.0, self.rest_before), self.period)
        begin = self.rest_before + move(0.0, self.amplitude, self.speed).duration
        stroke = move(-self.amplitude, self.amplitude, self.speed).duration
        time, voltage = np.arange(x.size) * self.period, np.full(x.size, self.low)
        for first in range(0, STROKES * self.rounds, STROKES):
            for place, rises in SWITCHES:
                at = begin + (first + place + self.share) * stroke
                voltage[time >= at] = self.high if rises else self.low
        return Drive(self.period, x, voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and the speed."""
        return Peaks(self.amplitude, top_speed(2 * self.amplitude, self.speed))
