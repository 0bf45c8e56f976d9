r"""Gas force: the force at rest at places along the stroke, there and back; the gas spring and its offset.

.. math:: x = -A, \ldots, A, \ldots, -A, \qquad \dot x = 0 \text{ for } hold \text{ seconds at each place}

At each place the mean of the force met on the way up and on the way down is the gas force, half of their difference the
friction. Without voltage friction is least, so leave it at 0 V.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from dampyr.campaigns.paths import around, driven, moves, top_speed
from dampyr.campaigns.step import Length, Peaks, Period, Rest, Speed, Time, Volts, check_ranges
from dampyr.rig import Drive, RigSettings
from dampyr.units import Quantity


@dataclass(frozen=True)
class GasForce:
    """A staircase of places."""

    amplitude: Annotated[float, Length, "distance from the middle to the outermost place"]
    places: Annotated[int, Quantity("", low=2.0), "number of places from -A to A"] = 7
    speed: Annotated[float, Speed, "speed between the places"] = 0.005
    hold: Annotated[float, Time, "time at each place"] = 2.0
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "speed", "voltage")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "places", "voltage")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True
    role: ClassVar[str] = "validation"  # nothing that a model could be fitted to

    def __post_init__(self) -> None:
        check_ranges(self)

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        up = [float(place) for place in np.linspace(-self.amplitude, self.amplitude, self.places)]
        pieces = list(moves([0.0, *up, *up[-2::-1], 0.0], self.speed, self.hold))
        return driven(around(pieces, 0.0, self.rest_before), self.period, self.voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and the speed, or what the longest move reaches: from the middle to the first place, or between two."""
        max_travel = self.amplitude * max(1.0, 2 / (self.places - 1))
        return Peaks(self.amplitude, top_speed(max_travel, self.speed))
