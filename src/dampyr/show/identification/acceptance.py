"""What the acceptance of a record shows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from dampyr.identification.acceptance_tests.acceptance import UNITS, Acceptance, AcceptancePoint
from dampyr.identification.acceptance_tests.reference_cycles import SAME, groups
from dampyr.input_kinds import ALL_RECORDS, NO_INPUT
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.acceptance import band_used, peak_velocity_band
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Table

Drawn = dict[bool | None, tuple[list[float], list[float]]]


@describe.register
def describe_acceptance(acceptance: Acceptance) -> Description:
    """Verdict, band, cycles and risks, the points, and the forces at peak velocity in the band."""
    a = acceptance
    rows = [
        ("verdict", a.verdict),
        *([("input", input_words(a))] if a.input != NO_INPUT else []),
        ("band", f"{a.tolerance} of the reference"),
        ("cycles", f"{a.run:g} run, {a.cut} whole, {a.judged_cycles} judged at {len(a.levels)} level(s)"),
        ("stroke", f"{1e3 * a.stroke_m:.4g} mm at most, judged to {1e3 * a.judged_stroke_m:.4g} mm"),
        ("points", f"{len(a.points)}, {len(a.judged)} judged, {len(a.outside)} outside"),
    ]
    worst = a.worst
    if worst is not None and worst.deviation is not None:
        rows.append(("worst", f"{worst.quantity} of cycle {worst.cycle}, {100 * worst.deviation:+.3g} %"))
    if a.wrong_rejection is not None and a.wrong_acceptance is not None:
        rejection, acceptance_chance = chance_in_words(a.wrong_rejection), chance_in_words(a.wrong_acceptance)
        rows.append(("risk", f"{rejection} wrong rejection, {acceptance_chance} wrong acceptance"))
    if a.unjudged:
        rows.append(("not judged", a.reason or next(iter(a.unjudged))))
    return Description(
        f"Acceptance of {a.record!r}",
        rows,
        tables=[lambda: _table(acceptance)],
        figure=lambda: peak_velocity_band(*forces_and_band([acceptance])) if acceptance.points else None,
        data=lambda: _numbers(acceptance),
        frame=lambda: _columns(acceptance),
    )


def _table(acceptance: Acceptance) -> Table:
    return Table(
        ("cycle", "quantity", "peak velocity", "measured", "expected", "from", "to", "unit", "inside"),
        [
            [p.cycle, p.quantity, 1e3 * p.speed, p.measured, p.expected, p.low, p.high, UNITS[p.quantity], p.inside]
            for p in acceptance.points
        ],
        ("", "", "mm/s", "", "", "", "", "", ""),
    )


def _numbers(acceptance: Acceptance) -> dict[str, Any]:
    """Plain numbers, for JSON."""
    points = [asdict(p) | {"deviation": p.deviation, "used": p.used} for p in acceptance.points]
    worst = next((entry for entry, p in zip(points, acceptance.points, strict=True) if p is acceptance.worst), None)
    return asdict(acceptance) | {
        "verdict": acceptance.verdict,
        "passed": acceptance.passed,
        "judged": len(acceptance.judged),
        "judged_cycles": acceptance.judged_cycles,
        "judged_stroke_m": acceptance.judged_stroke_m,
        "outside": len(acceptance.outside),
        "worst": worst,
        "reasons": acceptance.reasons,
        "points": points,
    }


def _columns(acceptance: Acceptance) -> DataFrameColumns:
    """The points: SI units, forces in compression negative."""
    names = {
        "cycle": "cycle", "level": "level", "quantity": "quantity", "speed": "speed_m_per_s", "stroke_m": "stroke_m",
        "measured": "measured", "error": "error", "expected": "expected", "low": "low", "high": "high", "inside": "inside",
        "deviation": "deviation", "reason": "reason",
    }  # fmt: skip
    columns = {head: [getattr(p, name) for p in acceptance.points] for name, head in names.items()}
    return DataFrameColumns(columns | {"unit": [UNITS[p.quantity] for p in acceptance.points]})


def input_words(acceptance: Acceptance) -> str:
    """Such as ``1.98 V``; ``all records`` where there is none."""
    if acceptance.input == NO_INPUT:
        return ALL_RECORDS
    return "input not known" if acceptance.input_value is None else f"{acceptance.input_value:.5g} {acceptance.input}"


def in_short(acceptances: Sequence[Acceptance]) -> str:
    """How many records came out how, such as "2 passed, 1 failed"."""
    counts = {
        verdict: sum(acceptance.verdict == verdict for acceptance in acceptances)
        for verdict in ("passed", "failed", "not judged")
    }
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)


def chance_in_words(chance: float | None) -> str | None:
    """A chance for a person: two digits, or a bound where it is next to nothing; None where it is not known."""
    if chance is None:
        return None
    return "below 0.01 %" if chance < 1e-4 else f"{100 * chance:.2g} %"


def band(acceptances: Iterable[Acceptance], quantity: str) -> list[tuple[float, float, float, float]]:
    """The band along the speed, for a picture: (speed m/s, expected, low, high), means of points with the same speed to 2 %."""
    points = [p for acceptance in acceptances for p in acceptance.judged if p.quantity == quantity]
    rows = np.array([(p.speed, p.expected, p.low, p.high) for p in points], dtype=float).reshape(-1, 4)
    return [(speed, middle, low, high) for speed, middle, low, high in groups(rows, SAME).tolist()]


def forces_and_band(acceptances: Sequence[Acceptance]) -> tuple[list[list[tuple[float, float, float, float]]], Drawn]:
    """The bands of extension and compression, and peak speeds m/s and forces N of the points inside, outside and not judged."""
    points: dict[bool | None, list[AcceptancePoint]] = {True: [], False: [], None: []}
    for acceptance in acceptances:
        for p in acceptance.points:
            if p.quantity != "energy":
                points[p.inside].append(p)
    drawn = {state: ([p.speed for p in alike], [p.measured for p in alike]) for state, alike in points.items()}
    return [band(acceptances, "extension"), band(acceptances, "compression")], drawn


def used_of_band(
    acceptances: Sequence[Acceptance],
) -> tuple[dict[str, dict[str, list[float]]], dict[str, dict[str, list[bool]]]]:
    """Record -> quantity -> what each judged cycle uses of the band (`AcceptancePoint.used`), and whether it lies outside."""
    used: dict[str, dict[str, list[float]]] = {
        acceptance.record: {
            q: [p.used or 0.0 for p in acceptance.judged if p.quantity == q] for q in acceptance.quantities
        }
        for acceptance in acceptances
    }
    outside: dict[str, dict[str, list[bool]]] = {
        acceptance.record: {
            q: [p.inside is False for p in acceptance.judged if p.quantity == q] for q in acceptance.quantities
        }
        for acceptance in acceptances
    }
    return used, outside


@dataclass(frozen=True)
class AcceptancePlots(Plots):
    """``acceptance.plot.forces()``, which is what ``acceptance.plot()`` draws, and ``.used()``."""

    @property
    def acceptances(self) -> tuple[Acceptance, ...]:
        """Those that are drawn."""
        return (self.result,)

    def forces(self) -> Any:
        """The forces at the peak velocities of every cycle, and the band."""
        return style.in_pyplot(peak_velocity_band, *forces_and_band(self.acceptances), origin=self.result.origin)

    def used(self) -> Any:
        """How far each judged cycle lies from the reference, in halves of the band: its edges are at -1 and 1."""
        used, outside = used_of_band(self.acceptances)
        return style.in_pyplot(band_used, used, outside=outside, origin=self.result.origin)


plots.register(Acceptance, AcceptancePlots)
