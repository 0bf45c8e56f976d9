r"""Sine: whole cycles of one amplitude and frequency at one voltage, the test that models are identified from.

.. math:: x = x_0 + A \sin 2 \pi f t

The first and the last ``taper`` cycles grow and fade as a raised cosine. Its peak speed is :math:`2 \pi f A`. One sine tells
amplitude and frequency apart only together with others: on a table limited in speed both change together, and a random
displacement or a sweep excites more.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import GLIDE, around, driven, start_of, swing, top_speed
from dampyr.campaigns.step import (
    Count,
    Frequency,
    Length,
    Peaks,
    Period,
    Place,
    Rest,
    Volts,
    check_ranges,
    enough_points,
)
from dampyr.records.cycle_analysis.device_figures import SteadyCycles
from dampyr.rig import Drive, RigSettings


@dataclass(frozen=True)
class Sine:
    """A tapered sine."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    frequency: Annotated[float, Frequency, "cycles per second"]
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    cycles: Annotated[int, Count, "number of steady cycles"] = 20
    taper: Annotated[int, Count, "number of cycles in which the motion grows, and fades"] = 1
    centre: Annotated[float, Place, "centre of the motion, from the middle of the stroke"] = 0.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "voltage")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "voltage")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        enough_points(self.period, self.frequency)

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        piece = swing(self.amplitude, self.frequency, self.cycles, self.taper, self.centre)
        return driven(around([piece], self.centre, self.rest_before), self.period, self.voltage)

    @property
    def steady_cycles(self) -> SteadyCycles:
        """Those between the tapers."""
        begin = start_of(self.centre, self.rest_before) + self.taper / self.frequency
        return SteadyCycles(begin, 1.0 / self.frequency, self.cycles)

    def peaks(self, rig: RigSettings) -> Peaks:
        """|x0| + A and 2 pi f A, or the glide to the centre where that is faster."""
        speed = 2 * pi * self.frequency * self.amplitude
        return Peaks(abs(self.centre) + self.amplitude, max(speed, top_speed(self.centre, GLIDE)))
