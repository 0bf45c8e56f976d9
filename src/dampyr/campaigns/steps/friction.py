r"""Friction: strokes at a constant speed with a pause before each; breaking away against sliding.

.. math:: |\dot x| = v \text{ between } -A \text{ and } A, \qquad \dot x = 0 \text{ for } pause \text{ seconds at each end}

Without a damper it measures what the guides and the seals of the table take as far as the load cell feels it; with one, the
damper's own. Half of the difference between the two directions is the friction, their mean the offset.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import around, driven, moves, top_speed
from dampyr.campaigns.step import Count, Length, Peaks, Period, Rest, Seconds, Speed, Volts, check_ranges
from dampyr.rig import Drive, RigSettings


@dataclass(frozen=True)
class Friction:
    """Strokes with pauses."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    speed: Annotated[float, Speed, "speed of the strokes"] = 0.005
    pause: Annotated[float, Seconds, "pause at each end of a stroke"] = 1.0
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    cycles: Annotated[int, Count, "number of strokes there and back"] = 3
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "speed", "voltage")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "speed", "voltage")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        turns = [self.amplitude, -self.amplitude] * self.cycles
        pieces = list(moves([0.0, *turns, 0.0], self.speed, self.pause))
        return driven(around(pieces, 0.0, self.rest_before), self.period, self.voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and the speed, or what a stroke too short for it reaches."""
        return Peaks(self.amplitude, top_speed(2 * self.amplitude, self.speed))
