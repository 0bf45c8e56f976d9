"""The page of an acceptance: which records lie within a band about a reference damper, and which points do not."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.figures.acceptance import band_used, peak_velocity_band
from dampyr.identification import Acceptance, Accepted
from dampyr.identification.acceptance_tests.acceptance import (
    BEYOND,
    UNITS,
    forces_and_band,
    in_short,
    percent,
    used_of_band,
)
from dampyr.report.blocks import Block, Cell, FigureBlock, Kind, Section, Table, Text, Verdict, to_look_at
from dampyr.report.html_page import page, write_page
from dampyr.representation import sentence

Array = NDArray[np.float64]
MAX_ROWS, MAX_FIGURES, MAX_POINTS = 40, 8, 60  # what a page can show and a person reads


def write_acceptance_page(result: Accepted, path: str | Path) -> Path:
    """Write the page of the result of `dampyr.identification.accept_records` and return its path.

    It shows verdicts, the band with the points, the points outside, and what was not judged. Raises
    :class:`~dampyr.errors.InputError` without any judgement.
    """
    results, reference = result.results, result.reference
    if not results:
        raise InputError("there is no judgement to show; judge one record or more")
    sections = [
        Section("In short", [*_short(results), *to_look_at(result.findings)]),
        Section("The levels", _levels(results)),
        Section("The forces at peak velocity", _forces(results)),
        Section("How much of the band is used", _used(results)),
        Section("The points outside", _outside(results)),
    ]
    if result.relevelled:
        sections.append(Section("With the level of the first cycles taken out", _relevelled(result.relevelled)))
    if any(one.unjudged for one in results):
        sections.append(Section("What was not judged", _open(results)))
    html = page(
        f"Judged by {Path(reference).name}",
        sections,
        subtitle=(
            f"Every whole cycle of every level of {_count(len(results), 'record')}, within {results[0].tolerance} of the "
            "reference."
        ),
        provenance={"reference": reference, "tolerance": str(results[0].tolerance), "offset": _offset(results[0])},
        call=f"dampyr.report.write_acceptance_page(result, {Path(path).name!r})",
        origin=result.origin,
    )
    return write_page(path, html)


def _relevelled(results: Sequence[Acceptance]) -> list[Block]:
    rows: list[list[Cell]] = [
        [one.record, one.level, _verdict(one), len(one.judged), len(one.outside), one.reason or ""] for one in results
    ]
    text = (
        f"{in_short(results).capitalize()}. The level of a record, measured over expected in its first cycles, is taken out of "
        "its later ones: what fails here fails by its shape and not by one factor on the force."
    )
    return [Text(text), Table(("record", "level", "verdict", "judged", "outside", ""), rows, digits=3)]


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _offset(one: Acceptance) -> str:
    if one.offset is None:
        return "the mean force over whole cycles, taken from each record and from the reference"
    return f"{one.offset:g} N, taken from every measured force"


def _input(one: Acceptance) -> str:
    return "input not known" if one.input_value is None else f"{one.input_value:.5g} {one.input}"


def _verdict(one: Acceptance) -> Verdict:
    return Verdict(one.verdict)


def _short(results: Sequence[Acceptance]) -> list[Block]:
    rows: list[list[Cell]] = []
    worst_rows: list[list[Cell]] = []
    for one in results:
        worst = one.worst
        off = None if worst is None or worst.deviation is None else 100 * worst.deviation
        rows.append(
            [one.record, _input(one), _verdict(one), one.run, one.cut, one.judged_cycles, 1e3 * one.stroke_m,
             1e3 * one.judged_stroke_m, len(one.outside)]
        )  # fmt: skip
        worst_rows.append(
            [one.record, worst.quantity if worst else None, worst.cycle if worst else None, off,
             _chance(one.wrong_rejection), _chance(one.wrong_acceptance)]
        )  # fmt: skip
    what = ", ".join(results[0].quantities)
    relative = results[0].tolerance.relative
    beyond = f"{100 * BEYOND * relative:.3g} % off" if relative else "off by a third more than is allowed"
    return [
        Text(
            f"{in_short(results).capitalize()}. Judged in every whole cycle, and in the mean over each level: {what}. One "
            "point or one mean outside fails a record; a record of which a level could not be judged in half of its cycles in "
            "one of these has neither passed nor failed."
        ),
        Table(
            ("record", "input", "verdict", "run", "cut", "judged", "stroke", "judged to", "outside"),
            rows,
            ("", "", "", "cycles", "cycles", "cycles", "mm", "mm", "points"),
            digits=4,
            caption="Cycles count from the start of the motion: those run, those of them that are whole, those judged.",
        ),
        Table(
            ("record", "worst", "cycle", "off by", "wrong rejection", "wrong acceptance"),
            worst_rows,
            ("", "", "", "%", "chance", "chance"),
            digits=3,
            caption=(
                "The worst point is the one that uses most of its band. Wrong rejection: the chance that a damper just like "
                f"the reference fails at this record's scatter. Wrong acceptance: that one passes which is {beyond} in one "
                "quantity at one level."
            ),
        ),
    ]


def _chance(chance: float | None) -> str | None:
    return None if chance is None else percent(chance)


def _levels(results: Sequence[Acceptance]) -> list[Block]:
    """The means of every level, and the scatter of single cycles."""
    names = results[0].quantities
    levels = [(one, each) for one in results for each in one.levels]
    if not levels:
        return [Text("No record has a whole cycle.")]
    rows: list[list[Cell]] = []
    for one, each in levels[:MAX_POINTS]:
        word: Kind = "failed" if each in one.levels_outside else "not judged" if each.reason else "passed"
        means = [_mean(each.deviation.get(q), each.scatter.get(q)) for q in names]
        judged = f"{each.judged} of {each.cycles}"
        rows.append([one.record, each.number, judged, 1e3 * each.stroke_m, each.frequency_hz, Verdict(word), *means])
    more = f" The first {MAX_POINTS} of {len(levels)}." if len(levels) > MAX_POINTS else ""
    return [
        Table(
            ("record", "level", "judged", "stroke", "frequency", "mean", *names),
            rows,
            ("", "", "cycles", "mm", "Hz", "", *("%" for _ in names)),
            digits=3,
            caption=f"Mean of measured over expected less 1, ± the standard deviation of a single cycle.{more}",
        )
    ]


def _mean(deviation: float | None, scatter: float | None) -> str | None:
    if deviation is None:
        return None
    text = f"{100 * deviation:+.1f}" + ("" if scatter is None else f" ± {100 * scatter:.1f}")
    return text.replace(" ", "\N{NO-BREAK SPACE}").replace("-", "\N{MINUS SIGN}")


def _forces(results: Sequence[Acceptance]) -> list[Block]:
    groups: dict[str, list[Acceptance]] = {}
    for one in sorted(results, key=lambda one: -np.inf if one.input_value is None else one.input_value):
        if one.points:
            groups.setdefault(_input(one), []).append(one)
    blocks: list[Block] = [
        FigureBlock(
            peak_velocity_band(*forces_and_band(some)),
            f"{name}: forces at the peak velocities of every cycle, extension above and compression below. The band is drawn "
            "through the mean of points of one speed; each point is judged by its own.",
        )
        for name, some in list(groups.items())[:MAX_FIGURES]
    ]
    if len(groups) > MAX_FIGURES:
        blocks.append(Text(f"There are {len(groups)} inputs; the lowest {MAX_FIGURES} are shown."))
    return blocks or [Text("No record has a whole cycle.")]


def _used(results: Sequence[Acceptance]) -> list[Block]:
    judged = [one for one in results if one.judged]
    if not judged:
        return [Text("No point was judged.")]
    worst = sorted(judged, key=lambda one: -abs(one.worst.used or 0.0) if one.worst else 0.0)[:MAX_ROWS]
    shown = [one for one in judged if one in worst]
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
    points = [(one.record, p) for one in results for p in one.outside]
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


def _open(results: Sequence[Acceptance]) -> list[Block]:
    rows: list[list[Cell]] = []
    for one in results:
        for reason, count in one.unjudged.items():
            rows.append([one.record, count, sentence(reason)])
    return [
        Text("A reference says nothing beyond its own tests and calibration, and nothing is extrapolated from it."),
        Table(("record", "points", "why"), rows),
    ]
