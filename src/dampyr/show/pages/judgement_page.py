"""The page of a judgement: which specimens hold the criteria, the loops of every level, and every cycle beside its limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from dampyr.campaigns.judgement import JudgedSpecimens, LevelVerdict, SpecimenVerdict
from dampyr.identification.acceptance_tests.device_criteria import Criterion
from dampyr.phrases import counted
from dampyr.show.campaigns.judgement import (
    cycle_table,
    in_short,
    level_table,
    quantity,
    specimen_loops,
    specimen_table,
    unjudged_table,
)
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.table import Table, Verdict


def html(result: JudgedSpecimens, *, call: str = "") -> str:
    """The page of the result of `dampyr.campaigns.judge`: verdicts, what was not judged, loops, and every cycle."""
    specimens = result.specimens
    sections = [Section("In short", [*_short(specimens), *to_look_at(result.findings)])]
    unjudged = unjudged_table(specimens)
    if unjudged.rows:
        text = Text("A specimen passes only where every level that its campaign asked was judged by every criterion.")
        sections.append(Section("What was not judged", [text, replace(unjudged, caption="")]))
    levels = level_table(specimens)
    unbroken = [[name, str(words).replace(" ", "\N{NO-BREAK SPACE}"), *rest] for name, words, *rest in levels.rows]
    sections.append(Section("The levels", [_with_marks(replace(levels, rows=unbroken, caption=""))]))
    sections.append(Section("The loops", _loops(specimens)))
    sections.append(Section("The criteria", [_criteria(result.criteria)]))
    for specimen in specimens:
        tables = [_cycles(specimen, level) for level in specimen.levels if level.cycles]
        same = sum(other.specimen == specimen.specimen for other in specimens) > 1
        name = f"{specimen.specimen}, {specimen.folder}" if same else specimen.specimen
        sections.append(Section(f"Every cycle of {name}", tables or [Text("No cycle was judged.")]))
    return page(
        f"Judged by {Path(result.name).name}",
        sections,
        subtitle=f"Every level that the campaigns of {counted(len(specimens), 'specimen')} asked.",
        provenance={"criteria": result.name, "folders": ", ".join(str(specimen.folder) for specimen in specimens)},
        call=call,
        origin=result.origin,
    )


def _short(specimens: Sequence[SpecimenVerdict]) -> list[Block]:
    text = Text(
        f"{in_short(specimens).capitalize()}. One value beyond its limit fails a specimen; one of which a level was not "
        "run to its end, or could not be judged, has neither passed nor failed."
    )
    return [text, _with_marks(_without(specimen_table(specimens), "folder"))]


def _loops(specimens: Sequence[SpecimenVerdict]) -> list[Block]:
    figures = [(specimen, specimen_loops(specimen)) for specimen in specimens]
    blocks: list[Block] = [
        FigureBlock(
            figure, f"{specimen.specimen}: the cycles of every level as they were judged, without run-in and run-out."
        )
        for specimen, figure in figures
        if figure
    ]
    return blocks or [Text("No level has a complete record.")]


def _cycles(specimen: SpecimenVerdict, level: LevelVerdict) -> Block:
    """Every criterion on every cycle of a level."""
    table = _with_marks(cycle_table([replace(specimen, levels=(level,))]))
    return replace(_without(_without(table, "specimen"), "level"), caption=f"{level.words}: {level.verdict}.")


def _criteria(criteria: Sequence[Criterion]) -> Table:
    return Table(
        ("quantity", "cycles", "reference", "from", "to", "source"),
        [
            [quantity(criterion), criterion.cycles, criterion.reference,
             *(None if side is None else 100.0 * side for side in (criterion.lower, criterion.upper)), criterion.source]
            for criterion in criteria
        ],
        ("", "", "", "%", "%", ""),
        notes=["Relative to the reference; a dash: that side is free."],
    )  # fmt: skip


def _without(table: Table, column: str) -> Table:
    """The table without a column."""
    k = list(table.columns).index(column)
    units = [*table.units[:k], *table.units[k + 1 :]]
    return replace(
        table,
        columns=[*table.columns[:k], *table.columns[k + 1 :]],
        rows=[[*row[:k], *row[k + 1 :]] for row in table.rows],
        units=units,
    )


def _with_marks(table: Table) -> Table:
    """The table with the marks of a page at its verdicts."""
    k = list(table.columns).index("verdict")
    return replace(table, rows=[[*row[:k], Verdict(row[k]), *row[k + 1 :]] for row in table.rows])  # type: ignore[arg-type]
