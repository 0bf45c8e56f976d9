"""Response time: strokes at a constant speed, the voltage switched within them, for each speed and pair of voltages.

As laboratories of adjustable dampers do it: a triangle, so that the speed stays constant, and a step of the input in either
direction of the motion. The drives are learned, for a load that jumps slows the motor. Judge t63, t90, dead time and settling
by limits of your own.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from dampyr.campaigns.protocol_result import ProtocolFigure, figures_of
from dampyr.campaigns.step import Count, Length, Speed, Volts
from dampyr.errors import InputError
from dampyr.records.cycle_analysis.step_response import StepResponse, response_times
from dampyr.records.record import Record


@dataclass(frozen=True)
class ResponseTime:
    """Steps of the voltage at several constant speeds."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    speeds: Annotated[tuple[float, ...], Speed, "constant speeds, in the order in which they run"]
    high_voltages: Annotated[tuple[float, ...], Volts, "voltages at the coil after a rise, one for each pair"]
    low_voltages: Annotated[
        tuple[float, ...], Volts, "voltages before a rise, one for each pair, or one for all of them"
    ] = (0.0,)
    rounds: Annotated[int, Count, "number of rises and of falls in each direction"] = 1

    quantities: ClassVar[Mapping[str, str]] = {"dead_time": "s", "t63": "s", "t90": "s", "settled": "s"}

    def __post_init__(self) -> None:
        if not self.speeds or not self.high_voltages:
            raise InputError('speeds and high_voltages need at least one value each, such as speeds = ["30 mm/s"]')
        if len(self.low_voltages) not in (1, len(self.high_voltages)):
            raise InputError(
                f"low_voltages has {len(self.low_voltages)} values and high_voltages {len(self.high_voltages)}; "
                "give one for each pair, or one for all"
            )

    def steps(self) -> list[dict[str, Any]]:
        """A voltage switch for each pair at each speed."""
        low = self.low_voltages * (len(self.high_voltages) if len(self.low_voltages) == 1 else 1)
        same = {"kind": "voltage_switch", "amplitude": self.amplitude, "rounds": self.rounds, "learn": True}
        return [
            {**same, "speed": speed, "low": u0, "high": u1}
            for u0, u1 in zip(low, self.high_voltages, strict=True)
            for speed in self.speeds
        ]

    def figures(self, records: Sequence[Record]) -> list[ProtocolFigure]:
        """Dead time, t63, t90 and settling of every step of the input."""
        return figures_of(
            records,
            lambda record: [f for found in response_times(record) for f in _figures(record, found)],
            self.quantities,
        )


def _figures(record: Record, found: StepResponse) -> list[ProtocolFigure]:
    step = json.loads(record.provenance["step"])
    conditions = {
        "speed": step["speed"], "low_voltage": step["low"], "high_voltage": step["high"],
        "direction": "extension" if found.extension else "compression", "step": found.step,
    }  # fmt: skip
    unsettled = "the force does not settle before the stroke ends"
    reasons = {"dead_time": found.reason, "settled": found.reason if found.t63 is None else unsettled}
    return [
        ProtocolFigure(
            record.name, name, value, conditions, "" if value is not None else reasons.get(name, found.reason)
        )
        for name in ResponseTime.quantities
        for value in [getattr(found, name)]
    ]
