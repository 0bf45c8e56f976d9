"""The page of an acceptance: which records lie within a band about a reference damper, and which points do not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.acceptance_tests.accept import Accepted
from dampyr.identification.acceptance_tests.acceptance import UNITS, Acceptance
from dampyr.phrases import counted
from dampyr.records import Record, cut_cycles, with_velocity
from dampyr.show.figures import style
from dampyr.show.figures.acceptance import band_used, peak_velocity_band
from dampyr.show.figures.failed_loops import FailedLoop, failed_loops
from dampyr.show.identification.accept import (
    judgement_table,
    level_table,
    relevelled_table,
    unjudged_table,
    worst_table,
)
from dampyr.show.identification.acceptance import forces_and_band, in_short, input_words, used_of_band
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.table import Cell, Table, Verdict

Array = NDArray[np.float64]
MAX_ROWS, MAX_FIGURES, MAX_POINTS, MAX_LOOPS = 40, 8, 60, 4  # what a page can show and a person reads


def html(result: Accepted, *, call: str = "") -> str:
    """The page of the result of `dampyr.identification.accept`.

    Its first screen holds the verdict and the loops of what failed; then come the points outside, the band, and every record.
    Raises :class:`~dampyr.errors.InputError` without any judgement.
    """
    results, reference = result.results, result.reference
    if not results:
        raise InputError("there is no judgement to show; judge one record or more")
    offset = results[0].offset
    offset_text = (
        "the mean force over whole cycles, taken from each record and from the reference"
        if offset is None
        else f"{offset:g} N, taken from every measured force"
    )
    sections = [
        Section("In short", [*_short(result), *to_look_at(result.findings)]),
        Section("The points outside", _outside(results)),
        Section("How much of the band is used", _used(results)),
        Section("The records", _records(results)),
        Section("The forces at peak velocity", _forces(results)),
        Section("The levels", _levels(results)),
    ]
    if result.relevelled:
        sections.append(Section("With the level of the first cycles taken out", _relevelled(result.relevelled)))
    if any(acceptance.unjudged for acceptance in results):
        text = Text(
            "A reference says nothing beyond its own tests and calibration, and nothing is extrapolated from it."
        )
        sections.append(Section("What was not judged", [text, replace(unjudged_table(results), caption="")]))
    return page(
        f"Judged by {Path(reference).name}",
        sections,
        subtitle=(
            f"Every whole cycle of every level of {counted(len(results), 'record')}, within {results[0].tolerance} of the "
            "reference."
        ),
        provenance={"reference": reference, "tolerance": str(results[0].tolerance), "offset": offset_text},
        call=call,
        origin=result.origin,
    )


def _relevelled(results: Sequence[Acceptance]) -> list[Block]:
    text = (
        f"{in_short(results).capitalize()}. The level of a record, measured over expected in its first cycles, is taken out of "
        "its later ones: what fails here fails by its shape and not by one factor on the force."
    )
    table = replace(relevelled_table(results), caption="The records, relevelled.", notes=())
    open_points = unjudged_table(results)
    worst = replace(worst_table(results), caption="The worst points, relevelled.", notes=())
    return [Text(text), _with_marks(table), worst, *([open_points] if open_points.rows else [])]


def _with_marks(table: Table) -> Table:
    """The table with the marks of a page at its verdicts."""
    k = list(table.columns).index("verdict")
    return replace(table, rows=[[*row[:k], Verdict(row[k]), *row[k + 1 :]] for row in table.rows])  # type: ignore[arg-type]


def _short(result: Accepted) -> list[Block]:
    """The verdict, and the loops of the records that failed worst."""
    results = result.results
    what = ", ".join(results[0].quantities)
    return [
        _verdict(result),
        Text(
            f"Judged in every whole cycle, and in the mean over each level: {what}. One "
            "point or one mean outside fails a record; a record of which a level could not be judged in half of its cycles in "
            "one of these has neither passed nor failed."
        ),
        *_failed(result),
    ]


def _verdict(result: Accepted) -> Verdict:
    """The verdict of all, with the worst point of the record that is farthest off and its limits."""
    worst = max(
        (acceptance for acceptance in result.results if acceptance.worst is not None),
        key=lambda acceptance: abs(acceptance.worst.used or 0.0),  # type: ignore[union-attr]
        default=None,
    )
    if worst is None or worst.worst is None:
        return Verdict(result.verdict, f"{in_short(result.results)}.")
    p, unit = worst.worst, UNITS[worst.worst.quantity]
    limits = "" if p.low is None or p.high is None else f", where {p.low:.4g} to {p.high:.4g} {unit} are allowed"
    at = "" if p.quantity == "energy" else f" at {1e3 * p.speed:.3g} mm/s"
    return Verdict(
        result.verdict,
        f"{in_short(result.results)}; the worst point is the {p.quantity} of cycle {p.cycle} of {worst.record}: "
        f"{p.measured:.4g} {unit}{at}{limits}.",
    )


def _failed(result: Accepted) -> list[Block]:
    """The loops of the records whose points lie farthest outside; nothing where none does, or the records are not at hand."""
    records = {record.name: record for record in result.records}
    failed = [a for a in result.results if any(p.quantity != "energy" for p in a.outside) and a.record in records]
    failed.sort(key=lambda acceptance: -max(abs(p.used or 0.0) for p in acceptance.outside))
    loops = {acceptance.record: _loop(records[acceptance.record], acceptance) for acceptance in failed[:MAX_LOOPS]}
    if not loops:
        return []
    several = f" The {MAX_LOOPS} worst of {len(failed)} records." if len(failed) > MAX_LOOPS else ""
    caption = (
        f"What failed: force over velocity, and each force outside at its peak velocity, beside its band.{several}"
    )
    return [FigureBlock(failed_loops(loops, result.origin), caption)]


def _loop(record: Record, acceptance: Acceptance) -> FailedLoop:
    """The whole cycles of a record without the offset that was judged without, and its forces outside."""
    cycles = cut_cycles(record).cycles
    whole = slice(cycles[0].first, cycles[-1].last + 1)
    velocity = with_velocity(record).velocity
    assert velocity is not None
    force = record.force[whole]
    offset = float(np.mean(force)) if acceptance.offset is None else acceptance.offset
    way = {"extension": 1.0, "compression": -1.0}
    outside = [
        (way[p.quantity] * p.speed, p.measured, float(p.low or 0.0), float(p.high or 0.0))
        for p in acceptance.outside
        if p.quantity in way
    ]
    return FailedLoop(velocity[whole], (force - offset) / acceptance.level, outside)


def _records(results: Sequence[Acceptance]) -> list[Block]:
    return [
        _with_marks(replace(judgement_table(results), caption="The records.")),
        worst_table(results),
    ]


def _levels(results: Sequence[Acceptance]) -> list[Block]:
    """The means of every level, and the scatter of single cycles."""
    table = level_table(results)
    count = len(table.rows)
    if not count:
        return [Text("No record has a whole cycle.")]
    more = [f"The first {MAX_POINTS} of {count}."] if count > MAX_POINTS else []
    return [_with_marks(replace(table, rows=table.rows[:MAX_POINTS], notes=[*table.notes, *more]))]


def _forces(results: Sequence[Acceptance]) -> list[Block]:
    groups: dict[str, list[Acceptance]] = {}
    for acceptance in sorted(results, key=lambda result: -np.inf if result.input_value is None else result.input_value):
        if acceptance.points:
            groups.setdefault(input_words(acceptance), []).append(acceptance)
    blocks: list[Block] = [
        FigureBlock(
            peak_velocity_band(*forces_and_band(group), share=style.HALF if len(groups) > 1 else 1.0),
            f"{name}: forces at the peak velocities of every cycle, extension above and compression below. The band is drawn "
            "through the mean of points of one speed; each point is judged by its own.",
        )
        for name, group in list(groups.items())[:MAX_FIGURES]
    ]
    if len(groups) > MAX_FIGURES:
        blocks.append(Text(f"There are {len(groups)} inputs; the lowest {MAX_FIGURES} are shown."))
    return blocks or [Text("No record has a whole cycle.")]


def _used(results: Sequence[Acceptance]) -> list[Block]:
    judged = [acceptance for acceptance in results if acceptance.judged]
    if not judged:
        return [Text("No point was judged.")]
    worst = sorted(judged, key=lambda result: -abs(result.worst.used or 0.0) if result.worst else 0.0)[:MAX_ROWS]
    shown = [acceptance for acceptance in judged if acceptance in worst]
    used, outside = used_of_band(shown)
    few = f" Of {len(judged)} records the {MAX_ROWS} worst are shown." if len(shown) < len(judged) else ""
    return [
        FigureBlock(
            band_used(used, outside=outside),
            "Every judged cycle of every record: 0 is the reference, the edges of the band are at −1 and 1. What noise "
            f"explains is allowed beyond them.{few}",
        )
    ]


def _outside(results: Sequence[Acceptance]) -> list[Block]:
    points = [(acceptance.record, p) for acceptance in results for p in acceptance.outside]
    if not points:
        return [Text("No point lies outside.")]
    points.sort(key=lambda pair: -abs(pair[1].used or 0.0))
    rows: list[list[Cell]] = [
        [name, p.cycle, p.quantity, 1e3 * p.speed, p.measured, p.low, p.high, UNITS[p.quantity],
         None if p.deviation is None else 100 * p.deviation]
        for name, p in points[:MAX_POINTS]
    ]  # fmt: skip
    more = f" The worst {MAX_POINTS} of {len(points)}." if len(points) > MAX_POINTS else ""
    return [
        Table(
            ("record", "cycle", "quantity", "peak velocity", "measured", "band from", "to", "unit", "off by"),
            rows,
            ("", "", "", "mm/s", "", "", "", "", "%"),
            digits=4,
            caption=f"Off by more than 0 % is stronger than the reference, in either direction.{more}",
        )
    ]
