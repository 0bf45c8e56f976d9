r"""Quasi-static: cycles so slow that viscosity has no part; what is left is friction, springs and gas.

.. math:: |\dot x| = v \text{ between } x_0 - A \text{ and } x_0 + A

reached and left in 0.1 s at each turn. Where friction itself depends on a low speed, use `low_velocity`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import GLIDE, around, driven, move, moves, start_of, top_speed
from dampyr.campaigns.step import Count, Length, Peaks, Period, Place, Rest, Speed, Volts, check_ranges
from dampyr.records.cycle_analysis.device_figures import SteadyCycles
from dampyr.rig import Drive, RigSettings


@dataclass(frozen=True)
class QuasiStatic:
    """Slow cycles at a constant speed."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    speed: Annotated[float, Speed, "speed between the turns"] = 0.002
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    cycles: Annotated[int, Count, "number of cycles, from turn to turn and back"] = 2
    centre: Annotated[float, Place, "centre of the motion, from the middle of the stroke"] = 0.0
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
        turns = [self.centre + self.amplitude, self.centre - self.amplitude] * self.cycles
        pieces = list(moves([self.centre, *turns, self.centre], self.speed))
        return driven(around(pieces, self.centre, self.rest_before), self.period, self.voltage)

    @property
    def steady_cycles(self) -> SteadyCycles | None:
        """From the first turn on, from turn to turn and back: one fewer than ``cycles``, for the way to the first turn and that
        from the last make up the other; None of a single cycle."""
        top, bottom = self.centre + self.amplitude, self.centre - self.amplitude
        begin = start_of(self.centre, self.rest_before) + move(self.centre, top, self.speed).duration
        period = 2.0 * move(top, bottom, self.speed).duration
        return SteadyCycles(begin, period, self.cycles - 1) if self.cycles > 1 else None

    def peaks(self, rig: RigSettings) -> Peaks:
        """|x0| + A and the speed, or what a stroke too short for it reaches."""
        speed = top_speed(2 * self.amplitude, self.speed)
        return Peaks(abs(self.centre) + self.amplitude, max(speed, top_speed(self.centre, GLIDE)))
