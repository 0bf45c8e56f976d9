"""Break-away: a rest under voltage, then a slow stroke, in either direction, for each dwell and voltage.

Seals and fluid that have rested take more force to move than to be kept moving. Of every stroke that follows a dwell the
break-away force is held against the kinetic force.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from dampyr.campaigns.protocol_result import ProtocolFigure, figures_of
from dampyr.campaigns.step import Count, Length, Speed, Time, Volts
from dampyr.errors import InputError
from dampyr.records.cycle_analysis.break_away_force import SMOOTHED, break_away_forces
from dampyr.records.record import Record

SAME_DWELL = (
    0.05  # relative, beside what the speed's smoothing takes: a rest of another length is none of the protocol's
)


@dataclass(frozen=True)
class BreakAway:
    """Dwells and slow strokes."""

    amplitude: Annotated[float, Length, "amplitude of the strokes, half of the peak to peak"]
    dwells: Annotated[tuple[float, ...], Time, "rests before the strokes, a test for each at each voltage"]
    voltages: Annotated[tuple[float, ...], Volts, "voltages at the coil, at rest as well"] = (0.0,)
    speed: Annotated[float, Speed, "speed of the strokes"] = 0.002
    strokes: Annotated[int, Count, "number of strokes there and back after each dwell"] = 2

    quantities: ClassVar[Mapping[str, str]] = {"break_away": "N", "kinetic": "N", "ratio": ""}

    def __post_init__(self) -> None:
        if not self.dwells or not self.voltages:
            raise InputError('dwells and voltages need at least one value each, such as dwells = ["10 s"]')
        if min(self.dwells) < 0.5:
            raise InputError(
                f"dwells = {min(self.dwells):g} s is too short to be told from a turn; give at least 0.5 s"
            )

    def steps(self) -> list[dict[str, Any]]:
        """Strokes with a pause before each, a test for each dwell at each voltage."""
        same = {"kind": "friction", "amplitude": self.amplitude, "speed": self.speed, "cycles": self.strokes}
        return [{**same, "voltage": voltage, "pause": dwell} for voltage in self.voltages for dwell in self.dwells]

    def figures(self, records: Sequence[Record]) -> list[ProtocolFigure]:
        """Break-away force, kinetic force and their ratio after every dwell."""
        return figures_of(records, _figures, self.quantities)


def _figures(record: Record) -> list[ProtocolFigure]:
    step = json.loads(record.provenance["step"])
    figures = []
    for found in break_away_forces(record):
        if abs(found.dwell - step["pause"]) > SAME_DWELL * step["pause"] + 2 * SMOOTHED:
            continue  # the rest before the motion, or after it
        conditions = {
            "dwell": step["pause"], "voltage": step["voltage"], "speed": step["speed"],
            "direction": "extension" if found.extension else "compression",
        }  # fmt: skip
        values = {"break_away": found.force, "kinetic": found.kinetic, "ratio": found.ratio}
        figures += [
            ProtocolFigure(record.name, name, value, conditions, found.reason) for name, value in values.items()
        ]
    return figures
