"""What the acceptance of many records shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from dampyr.findings import as_dicts
from dampyr.identification.acceptance_tests.accept import Accepted
from dampyr.identification.acceptance_tests.acceptance import BEYOND, Acceptance, JudgedLevel
from dampyr.input_kinds import NO_INPUT
from dampyr.phrases import counted, sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.acceptance import band_used
from dampyr.show.identification.acceptance import AcceptancePlots, chance_in_words, in_short, input_words, used_of_band
from dampyr.show.plots import plots
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@describe.register
def describe_accepted(accepted: Accepted) -> Description:
    """The verdict of all, how many records came out how; tables of records, worst points and levels, and of what was not
    judged; what each uses of the band."""
    results, relevelled = accepted.results, accepted.relevelled
    rows = [("verdict", accepted.verdict), ("records", in_short(results))]
    band = ""
    if results:
        first = results[0]
        band = f", {first.tolerance}"
        rows.append(("band", f"{first.tolerance}, judged by {', '.join(first.quantities)}"))
    tables = [
        lambda: judgement_table(results),
        lambda: worst_table(results),
        lambda: unjudged_table(results),
        lambda: level_table(results),
    ]
    if relevelled:
        tables += [
            lambda: relevelled_table(relevelled),
            lambda: replace(worst_table(relevelled), caption="The worst points, relevelled.", notes=()),
            lambda: replace(unjudged_table(relevelled), caption="What was not judged, relevelled."),
        ]
    return Description(
        f"Accepted by {accepted.reference!r}",
        rows,
        verdict=[f"The verdict of all is: {accepted.verdict}, by {accepted.reference}{band}."],
        tables=tables,
        figure=lambda: _figure(accepted),
        data=lambda: _numbers(accepted),
        frame=lambda: _columns(accepted),
    )


def _figure(accepted: Accepted) -> Figure | None:
    judged = [acceptance for acceptance in accepted.results if acceptance.judged]
    used, outside = used_of_band(judged)
    return band_used(used, outside=outside) if judged else None


def judgement_table(results: Sequence[Acceptance]) -> Table:
    """How each record came out: its cycles, strokes and points, and how far the worst of these is off."""
    table = Table(
        ("record", "input", "verdict", "run", "judged", "stroke", "judged to", "outside", "worst off by"),
        [
            [
                acceptance.record,
                input_words(acceptance),
                acceptance.verdict,
                acceptance.run,
                f"{acceptance.judged_cycles} of {acceptance.cut}",
                1e3 * acceptance.stroke_m,
                _judged_to(acceptance),
                len(acceptance.outside),
                _worst_off_by(acceptance),
            ]
            for acceptance in results
        ],
        ("", "", "", "cycles", "whole cycles", "mm", "mm", "points", "%"),
        caption=f"{counted(len(results), 'record')}: {in_short(results)}.",
        notes=[
            "Run: cycles from the start of the motion; judged: those of the whole ones that were judged; judged to: the "
            "largest stroke among them."
        ],
        digits=4,
    )
    return _without_input(table, results)


def _without_input(table: Table, results: Sequence[Acceptance]) -> Table:
    """The table, without the column of the input where no record has one."""
    return table.without("input") if results and all(result.input == NO_INPUT for result in results) else table


def worst_table(results: Sequence[Acceptance]) -> Table:
    """The worst point of each record, and the chances of a wrong verdict."""
    off = BEYOND * results[0].tolerance.relative if results else 0.0
    beyond = f"{100 * off:.3g} % off" if off else "off by a third more than is allowed"
    return Table(
        ("record", "worst", "cycle", "speed", "measured", "expected", "off by", "wrong rejection", "wrong acceptance"),
        [
            [
                acceptance.record,
                *_worst_point(acceptance),
                chance_in_words(acceptance.wrong_rejection),
                chance_in_words(acceptance.wrong_acceptance),
            ]
            for acceptance in results
        ],
        ("", "", "", "mm/s", "N or J", "N or J", "%", "chance", "chance"),
        caption="The worst point of each record, and the chances of a wrong verdict.",
        notes=[
            "The worst point is the one that uses most of its band. Wrong rejection: the chance that a damper just like the "
            f"reference fails at this record's scatter. Wrong acceptance: that one passes which is {beyond} in one quantity at "
            "one level."
        ],
        digits=4,
    )


def _worst_point(acceptance: Acceptance) -> list[Cell]:
    worst = acceptance.worst
    if worst is None:
        return [None] * 6
    return [worst.quantity, worst.cycle, 1e3 * worst.speed, worst.measured, worst.expected, _worst_off_by(acceptance)]


def _judged_to(acceptance: Acceptance) -> float | None:
    """The largest stroke of a judged cycle, mm."""
    return 1e3 * acceptance.judged_stroke_m if acceptance.judged else None


def _worst_off_by(acceptance: Acceptance) -> float | None:
    return None if acceptance.worst is None or acceptance.worst.deviation is None else 100 * acceptance.worst.deviation


def level_table(results: Sequence[Acceptance]) -> Table:
    """The means of every level, and the scatter of single cycles."""
    names = results[0].quantities if results else ()
    rows: list[list[Cell]] = [
        [acceptance.record, level.number, level.cycles, level.judged, 1e3 * level.stroke_m, level.frequency_hz,
         _verdict_of_level(acceptance, level), *(_mean_text(level.deviation.get(q), level.scatter.get(q)) for q in names)]
        for acceptance in results for level in acceptance.levels
    ]  # fmt: skip
    return Table(
        ("record", "level", "cycles", "judged", "stroke", "frequency", "verdict", *names),
        rows,
        ("", "", "", "cycles", "mm", "Hz", "", *("%" for _ in names)),
        caption="Means of each level.",
        notes=["The mean of measured over expected less 1, ± the standard deviation of a single cycle."],
        digits=4,
    )


def _verdict_of_level(acceptance: Acceptance, level: JudgedLevel) -> str:
    return "failed" if level in acceptance.levels_outside else "not judged" if level.reason else "passed"


def _mean_text(deviation: float | None, scatter: float | None) -> str | None:
    if deviation is None:
        return None
    text = f"{100 * deviation:+.2f}" + ("" if scatter is None else f" ± {100 * scatter:.2f}")
    return text.replace(" ", "\N{NO-BREAK SPACE}").replace("-", "\N{MINUS SIGN}")


def relevelled_table(results: Sequence[Acceptance]) -> Table:
    """How each record came out with the level of its first cycles taken out of the later ones."""
    table = Table(
        ("record", "input", "level", "verdict", "judged", "judged", "judged to", "outside", "worst off by"),
        [
            [
                acceptance.record,
                input_words(acceptance),
                None if math.isnan(acceptance.level) else acceptance.level,
                acceptance.verdict,
                acceptance.judged_cycles,
                len(acceptance.judged),
                _judged_to(acceptance),
                len(acceptance.outside),
                _worst_off_by(acceptance),
            ]
            for acceptance in results
        ],
        ("", "", "", "", "cycles", "points", "mm", "points", "%"),
        caption=f"Relevelled by the first cycles: {in_short(results)}.",
        notes=["Level: measured over expected in the first cycles, which is taken out of the later ones."],
        digits=4,
    )
    return _without_input(table, results)


def unjudged_table(results: Sequence[Acceptance]) -> Table:
    """How many points of each record were not judged, and why."""
    rows: list[list[Cell]] = [
        [acceptance.record, count, sentence(reason)]
        for acceptance in results
        for reason, count in acceptance.unjudged.items()
    ]
    return Table(("record", "points", "why"), rows, caption="What was not judged.")


def _numbers(accepted: Accepted) -> dict[str, Any]:
    """All results for JSON, SI units."""
    records = [acceptance.as_dict() for acceptance in accepted.results]
    more = {"relevelled": [acceptance.as_dict() for acceptance in accepted.relevelled]} if accepted.relevelled else {}
    answer = {
        "reference": accepted.reference,
        "origin": accepted.origin.as_dict(),
        "verdict": accepted.verdict,
        "findings": as_dicts(accepted.findings),
        "records": records,
    }
    return dict(plain(answer | more))


def _columns(accepted: Accepted) -> DataFrameColumns:
    """The judgement of each record; ``worst_deviation`` is a ratio."""
    results = accepted.results
    columns = {
        "input": [acceptance.input_value for acceptance in results],
        "verdict": [acceptance.verdict for acceptance in results],
        "run": [acceptance.run for acceptance in results],
        "cut": [acceptance.cut for acceptance in results],
        "judged_cycles": [acceptance.judged_cycles for acceptance in results],
        "judged_stroke_m": [acceptance.judged_stroke_m for acceptance in results],
        "points": [len(acceptance.points) for acceptance in results],
        "judged": [len(acceptance.judged) for acceptance in results],
        "outside": [len(acceptance.outside) for acceptance in results],
        "worst_deviation": [acceptance.worst.deviation if acceptance.worst else None for acceptance in results],
        "wrong_rejection": [acceptance.wrong_rejection for acceptance in results],
        "wrong_acceptance": [acceptance.wrong_acceptance for acceptance in results],
    }
    return DataFrameColumns(columns, [acceptance.record for acceptance in results], "record")


@dataclass(frozen=True)
class AcceptedPlots(AcceptancePlots):
    """The figures of all records: ``accepted.plot.forces()`` and ``.used()``; ``accepted.plot()`` leaves out records of which
    nothing was judged."""

    @property
    def acceptances(self) -> tuple[Acceptance, ...]:
        """Those that are drawn."""
        results: tuple[Acceptance, ...] = self.result.results
        return results


plots.register(Accepted, AcceptedPlots)
