r"""Peak velocity: a shock dynamometer's run, warm-up and gas force first, then one sine for each peak speed.

.. math:: f = v / (\pi s)

s is the stroke, from turn to turn. The order, warm-up, gas test, speeds, is that of a Roehrig test. A speed's force is that of
the last whole cycle within 5 % of the stroke about its middle, the largest in extension and the least in compression, the gas
force taken off; the raw force is kept beside it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Annotated, Any, ClassVar

from dampyr.campaigns.protocol_result import ProtocolFigure, figures_of
from dampyr.campaigns.step import Count, Length, Speed, Volts
from dampyr.config import Choices
from dampyr.errors import InputError
from dampyr.records.cycle_analysis.mid_stroke_force import GasForceCurve, gas_force_curve, mid_stroke_force
from dampyr.records.record import Record
from dampyr.units import Quantity

SIGNS = {"extension positive": 1.0, "compression positive": -1.0}
OFF_SPEED = 0.1  # of the speed asked for: a force at another speed is none of this one's


@dataclass(frozen=True)
class PeakVelocity:
    """Sines of one stroke at several peak speeds, at each of the inputs."""

    stroke: Annotated[float, Length, "stroke, from turn to turn"]
    speeds: Annotated[tuple[float, ...], Speed, "peak speeds, in the order in which they run"]
    voltages: Annotated[tuple[float, ...], Volts, "voltages at the coil; all speeds at each"] = (0.0,)
    cycles: Annotated[int, Count, "steady cycles at each speed"] = 5
    warm_up_cycles: Annotated[int, Count, "cycles of the warm-up at the largest speed, at most"] = 50
    warm_up_temperature: Annotated[
        float | None, Quantity("degC"), "temperature at which the warm-up ends early; none: it ends after its cycles"
    ] = None
    sign: Annotated[str, Choices(SIGNS), "sign of the forces that are shown and judged"] = "extension positive"

    quantities: ClassVar[Mapping[str, str]] = {"force": "N", "raw_force": "N", "gas_force": "N"}

    def __post_init__(self) -> None:
        if not self.speeds or not self.voltages:
            raise InputError(
                'speeds and voltages need at least one value each; give a list such as speeds = ["50 mm/s"]'
            )

    def steps(self) -> list[dict[str, Any]]:
        """Warm-up at the largest speed, gas force without voltage, then every speed at every voltage."""
        amplitude = 0.5 * self.stroke
        warm_up = {"kind": "warm_up", "amplitude": amplitude, "frequency": self._frequency(max(self.speeds))}
        warm_up |= {"cycles": self.warm_up_cycles, "temperature": self.warm_up_temperature}
        sines = [
            {"kind": "sine", "amplitude": amplitude, "frequency": self._frequency(speed), "voltage": voltage}
            for voltage in self.voltages
            for speed in self.speeds
        ]
        return [
            warm_up,
            {"kind": "gas_force", "amplitude": amplitude},
            *(sine | {"cycles": self.cycles} for sine in sines),
        ]

    def figures(self, records: Sequence[Record]) -> list[ProtocolFigure]:
        """The gas force at mid-stroke, and the force at each speed and voltage in either direction, without it and raw."""
        of_kind = {kind: [r for r in records if r.provenance["kind"] == kind] for kind in ("gas_force", "sine")}
        curves: list[GasForceCurve] = []
        sign = SIGNS[self.sign]

        def at_rest(record: Record) -> list[ProtocolFigure]:
            curves.append(gas_force_curve(record))
            return [ProtocolFigure(record.name, "gas_force", sign * curves[0].at(0.0))]

        figures = figures_of(of_kind["gas_force"], at_rest, ["gas_force"])
        gas = curves[0] if curves else None
        return figures + figures_of(of_kind["sine"], lambda record: _figures(record, gas, sign), ["force", "raw_force"])

    def _frequency(self, speed: float) -> float:
        return speed / (pi * self.stroke)


def _figures(record: Record, gas: GasForceCurve | None, sign: float) -> list[ProtocolFigure]:
    step = json.loads(record.provenance["step"])
    found, speed = mid_stroke_force(record), 2.0 * pi * step["amplitude"] * step["frequency"]
    off = found.speed / speed - 1.0
    reason = "" if abs(off) <= OFF_SPEED else f"the speed at mid-stroke is {100 * off:+.3g} % off; learn the drive"
    without = reason or ("" if gas else "no record gives the gas force")
    figures = []
    for direction, raw in (("extension", found.extension), ("compression", found.compression)):
        same = {"speed": speed, "voltage": step["voltage"], "direction": direction}
        force = None if without or gas is None else sign * (raw - gas.at(found.place))
        figures.append(ProtocolFigure(record.name, "force", force, same, without))
        figures.append(ProtocolFigure(record.name, "raw_force", None if reason else sign * raw, same, reason))
    return figures
