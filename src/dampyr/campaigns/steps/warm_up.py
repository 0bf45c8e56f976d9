r"""Warm-up: cycles that bring the fluid to a temperature, or just a number of cycles.

.. math:: x = A \sin 2 \pi f t

The force of a damper falls while it warms up, so the first tests of a day are unlike the others without it. Where the rig
has no thermocouple, give cycles and leave the temperature out. The test ends early when the temperature is reached.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import around, sampled, swing
from dampyr.campaigns.step import (
    Count,
    Frequency,
    Length,
    Peaks,
    Period,
    Rest,
    Volts,
    check_ranges,
    enough_points,
)
from dampyr.rig import Drive, RigSettings
from dampyr.units import Quantity


@dataclass(frozen=True)
class WarmUp:
    """Cycles until a temperature is reached, at most ``cycles`` of them."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    frequency: Annotated[float, Frequency, "cycles per second"]
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    cycles: Annotated[int, Count, "number of steady cycles at most"] = 50
    temperature: Annotated[
        float | None, Quantity("degC"), "temperature at which the test ends early; none: it ends after its cycles"
    ] = None
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "voltage")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "frequency", "voltage", "temperature")
    fixed: ClassVar[bool] = True
    learns: ClassVar[bool] = False
    role: ClassVar[str] = "validation"  # nothing that a model could be fitted to

    def __post_init__(self) -> None:
        check_ranges(self)
        enough_points(self.period, self.frequency)

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil, and the temperature at which they end early."""
        piece = swing(self.amplitude, self.frequency, self.cycles, 1)
        x = sampled(around([piece], 0.0, self.rest_before), self.period)
        return Drive(self.period, x, x * 0 + self.voltage, until_temperature=self.temperature)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and 2 pi f A."""
        return Peaks(self.amplitude, 2 * pi * self.frequency * self.amplitude)
