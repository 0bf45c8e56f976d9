"""What the comparison of a graphical method with least squares shows."""

from __future__ import annotations

from typing import Any

from dampyr.findings import as_dicts
from dampyr.identification.limit_cycle_methods.method_comparison import METHODS, MethodComparison, MethodResult
from dampyr.identification.scoring.score import Score
from dampyr.input_kinds import NO_INPUT, unit_of
from dampyr.phrases import counted, percent
from dampyr.show.descriptions import Description, describe
from dampyr.show.table import Cell, Table
from dampyr.units import for_people

UNITS = {"kx": "N s/m", "kw": "N", "rho": "1/m"}


@describe.register
def describe_comparison(comparison: MethodComparison) -> Description:
    """The mean errors of both, and their numbers by record."""
    means = {name: _mean(comparison, name) for name in ("score", "least_squares_score")}
    return Description(
        f"MethodComparison {comparison.method!r}",
        [
            ("records", counted(len(comparison.results), "record")),
            ("method", METHODS.words[comparison.method]),
            ("L1", means["score"]),
            ("L1 of least squares", means["least_squares_score"]),
        ],
        verdict=[
            f"The method {comparison.method} predicts its records with L1 {means['score']} on average, a fit by least squares "
            f"with {means['least_squares_score']}."
        ],
        tables=[lambda: comparison_table(comparison)],
        data=lambda: {
            "method": comparison.method,
            "origin": comparison.origin.as_dict(),
            "findings": as_dicts(comparison.findings),
            "results": [_numbers(result) for result in comparison.results],
        },
    )


def comparison_table(comparison: MethodComparison) -> Table:
    """Numbers and L1 ratio of both methods, a row a record."""
    shown = {name: for_people(unit) for name, unit in UNITS.items()}
    rows: list[list[Cell]] = []
    for result in comparison.results:
        row: list[Cell] = [result.record, result.input_value]
        for numbers, score in (
            (result.numbers, result.score),
            (result.least_squares, result.least_squares_score),
        ):
            row += [numbers[name] * factor if name in numbers else None for name, (_, factor) in shown.items()]
            row.append(100 * score.l1 if isinstance(score, Score) else None)
        rows.append(row)
    head = [*UNITS, "L1", *(f"{name}, least squares" for name in (*UNITS, "L1"))]
    units = [*(unit for unit, _ in shown.values()), "%"]
    reasons = [f"{r.record}: {r.score}." for r in comparison.results if isinstance(r.score, str)]
    kind = comparison.records[0].input
    table = Table(
        ("record", "input", *head),
        rows,
        ("", unit_of(kind), *units, *units),
        caption=f"Viscous Dahl model by the method {comparison.method}, beside least squares.",
        notes=reasons,
        digits=4,
    )
    return table.without("input") if kind == NO_INPUT else table


def _mean(comparison: MethodComparison, name: str) -> str:
    values = [score.l1 for result in comparison.results if isinstance(score := getattr(result, name), Score)]
    return percent(sum(values) / len(values)) if values else "none"


def _numbers(result: MethodResult) -> dict[str, Any]:
    scores = {"score": result.score, "least_squares_score": result.least_squares_score}
    return {
        "record": result.record,
        "input": result.input_value,
        "numbers": result.numbers,
        "least_squares": result.least_squares,
    } | {name: {"problem": score} if isinstance(score, str) else score.as_dict() for name, score in scores.items()}
