r"""Low velocity: one cycle at each of several low speeds; how the force rolls off towards standstill.

.. math:: |\dot x| = v_1, v_2, \ldots \text{ between } -A \text{ and } A

Here models that agree at high speeds part. Slow cycles are long: A = 2 mm at 0.2 mm/s takes 40 s. The encoder's count must be
small beside the distance between samples that is looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import around, driven, moves, top_speed
from dampyr.campaigns.step import Length, Peaks, Period, Rest, Speed, Volts, check_ranges
from dampyr.errors import InputError
from dampyr.rig import Drive, RigSettings


@dataclass(frozen=True)
class LowVelocity:
    """Cycles at low constant speeds."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"] = 0.002
    speeds: Annotated[tuple[float, ...], Speed, "speeds, one cycle at each in this order"] = (
        0.0005,
        0.001,
        0.002,
        0.005,
    )
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "voltage")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "speeds", "voltage")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.speeds:
            raise InputError("speeds is empty; give at least one speed")

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        cycle = (0.0, self.amplitude, -self.amplitude, 0.0)
        pieces = list(chain.from_iterable(moves(cycle, speed) for speed in self.speeds))
        return driven(around(pieces, 0.0, self.rest_before), self.period, self.voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and the highest of the speeds, or what a stroke too short for it reaches."""
        return Peaks(self.amplitude, top_speed(2 * self.amplitude, max(self.speeds)))
