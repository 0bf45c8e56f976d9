"""Quasi-static test by NTC 2018 section 11.9.3: at least five full cycles at plus and minus the design displacement d2.

Read in two transcriptions of the law that agree, not in the Gazette. The stability of the cycles is judged against the third.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from dampyr.campaigns.step import Count, Length, Speed, Volts
from dampyr.errors import InputError

LEAST_CYCLES = 5


@dataclass(frozen=True)
class Ntc2018QuasiStatic:
    """Slow full cycles at the design displacement, at each of the inputs."""

    design_displacement: Annotated[float, Length, "design displacement d2"]
    voltages: Annotated[tuple[float, ...], Volts, "voltages at the coil, one test for each"] = (0.0,)
    cycles: Annotated[int, Count, "number of full cycles, at least 5"] = LEAST_CYCLES
    speed: Annotated[float, Speed, "speed between the turns"] = 0.002

    def __post_init__(self) -> None:
        if not self.voltages:
            raise InputError("voltages = [] is empty; give at least one value")
        if self.cycles < LEAST_CYCLES:
            raise InputError(f"cycles = {self.cycles} is not allowed; NTC 2018 11.9.3 asks for at least {LEAST_CYCLES}")

    def steps(self) -> list[dict[str, Any]]:
        """A quasi-static test for each voltage."""
        same = {
            "kind": "quasi_static",
            "amplitude": self.design_displacement,
            "speed": self.speed,
            "cycles": self.cycles + 1,  # the way to the first turn and from the last one are no full cycle
        }
        return [{**same, "voltage": voltage} for voltage in self.voltages]
