r"""Rest: the table stands, the coil has a voltage or none; for cooling, and for reading zeros and noise.

.. math:: x = 0

Between all tests of a campaign use ``rest_between`` instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import driven, hold
from dampyr.campaigns.step import Peaks, Period, Time, Volts, check_ranges
from dampyr.rig import Drive, RigSettings


@dataclass(frozen=True)
class Rest:
    """No motion."""

    duration: Annotated[float, Time, "duration of the rest"]
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("duration", "voltage")
    named: ClassVar[tuple[str, ...]] = ("duration", "voltage")
    fixed: ClassVar[bool] = True
    learns: ClassVar[bool] = False
    role: ClassVar[str] = "validation"  # nothing that a model could be fitted to

    def __post_init__(self) -> None:
        check_ranges(self)

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        return driven([hold(0.0, max(self.duration, self.period))], self.period, self.voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """Nothing moves."""
        return Peaks(0.0, 0.0)
