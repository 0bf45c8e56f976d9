"""Isolator by BNBC 2020 section 2.5.16.4: wind, then parts of the design displacement, then the larger displacements.

Read in the text of the code: 20 fully reversed cycles at the wind force; 3 at 0.25, 0.5 and 1.0 of the design displacement and
at the maximum displacement; 3 at the total maximum and at least 10 at the total design displacement. The vertical load that
it asks for is no business of a table that moves one damper: state it in the campaign's note. The table follows displacements,
so the wind enters as the displacement that its force makes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from dampyr.campaigns.step import Frequency, Length, Volts
from dampyr.errors import InputError

FRACTIONS = (0.25, 0.5, 1.0)  # of the design displacement
WIND_CYCLES, CYCLES, TOTAL_DESIGN_CYCLES = 20, 3, 10


@dataclass(frozen=True)
class Bnbc2020Isolator:
    """The sequence of BNBC 2020 for isolators."""

    wind_displacement: Annotated[float, Length, "displacement at the wind force"]
    design_displacement: Annotated[float, Length, "design displacement DD"]
    maximum_displacement: Annotated[float, Length, "maximum displacement DM"]
    total_design_displacement: Annotated[float, Length, "total design displacement DTD"]
    total_maximum_displacement: Annotated[float, Length, "total maximum displacement DTM"]
    frequency: Annotated[float, Frequency, "cycles per second"]
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0

    def __post_init__(self) -> None:
        for smaller, larger in (
            ("design_displacement", "maximum_displacement"),
            ("design_displacement", "total_design_displacement"),
            ("maximum_displacement", "total_maximum_displacement"),
            ("total_design_displacement", "total_maximum_displacement"),
        ):
            low, high = getattr(self, smaller), getattr(self, larger)
            if low > high:
                raise InputError(
                    f"{smaller} = {1e3 * low:g} mm is more than {larger} = {1e3 * high:g} mm; "
                    "state both as the code defines them"
                )

    def steps(self) -> list[dict[str, Any]]:
        """Wind, the design displacement in three steps, the maximum, the total maximum and the total design displacement."""
        levels = [(self.wind_displacement, WIND_CYCLES)]
        levels += [(fraction * self.design_displacement, CYCLES) for fraction in FRACTIONS]
        levels += [(self.maximum_displacement, CYCLES), (self.total_maximum_displacement, CYCLES)]
        levels.append((self.total_design_displacement, TOTAL_DESIGN_CYCLES))
        same = {"kind": "sine", "frequency": self.frequency, "voltage": self.voltage}
        return [{**same, "amplitude": amplitude, "cycles": cycles} for amplitude, cycles in levels]
