"""A study that is a list of numbers: published values beside ours, the page, and the numbers for machines.

A module of `dampyr.studies` that has ``reproduce(data, out, progress=...)`` is a study that ``dampyr reproduce`` runs.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from dampyr.origin import VIRTUAL, Origin
from dampyr.phrases import sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.published_beside_ours import published_beside_ours
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.pages.html_page import number, page, write_html
from dampyr.show.table import Cell, Table, Verdict
from dampyr.shown import Shown
from dampyr.studies._compared_value import ComparedValue, Outcome

Progress = Callable[[str, float], None]
OUTCOMES: tuple[Outcome, ...] = ("agrees", "differs", "cannot be checked")


@dataclass(frozen=True, repr=False)
class StudyRun(Shown):
    """The numbers of a study that was run again; ``left_out`` says what of it was not done, and why."""

    name: str
    title: str
    source: str
    compared: tuple[ComparedValue, ...]
    left_out: tuple[str, ...] = ()
    page: Path | None = None
    origin: Origin = VIRTUAL


@describe.register
def describe_study_run(study: StudyRun) -> Description:
    """How many numbers have which verdict, and what was left out; all of them in a table."""
    verdicts = Counter(value.verdict for value in study.compared)
    rows = [
        ("source", study.source),
        ("compared", ", ".join(f"{verdicts[outcome]} {outcome}" for outcome in OUTCOMES if verdicts[outcome])),
        ("left out", "; ".join(study.left_out)),
        ("page", "" if study.page is None else study.page.name),
    ]
    return Description(
        f"StudyRun of {study.title}",
        [row for row in rows if row[1]],
        verdict=[
            *(sentence(f"{v.artefact}, {v.quantity}: {v.reason}") for v in study.compared if v.verdict == "differs"),
            *(sentence(f"left out: {omission}") for omission in study.left_out),
        ],
        tables=[lambda: _in_short(study)],
        data=lambda: _numbers(study),
        frame=lambda: DataFrameColumns(
            {
                name: [getattr(value, name) for value in study.compared]
                for name in ("artefact", "quantity", "published", "ours", "unit", "verdict", "reason")
            }
        ),
    )


def _in_short(study: StudyRun) -> Table:
    """Published beside ours, with the verdict and not its reason."""
    table = compared_table(study.compared, digits=5)
    return replace(
        table, rows=[[*row[:-1], value.verdict] for row, value in zip(table.rows, study.compared, strict=True)]
    )


def write(study: StudyRun, out: Path | None) -> StudyRun:
    """``NAME.html`` and ``NAME.json`` in ``out``; returns the study with its page. None writes nothing."""
    if out is None:
        return study
    written = replace(study, page=write_html(out / f"{study.name}.html", html(study)))
    text = json.dumps(written.as_dict(), indent=2, ensure_ascii=False, allow_nan=False)
    (out / f"{study.name}.json").write_text(text + "\n", encoding="utf-8")
    return written


def html(study: StudyRun) -> str:
    """The whole page."""
    figure = comparison_figure(study.compared)
    blocks: list[Block] = [] if figure is None else [figure]
    sections = [Section("Published beside ours", [*blocks, compared_table(study.compared, digits=5)])]
    if study.left_out:
        sections.append(Section("What was left out", [Text("\n\n".join(map(sentence, study.left_out)))]))
    lead = "Every published number beside ours, with a verdict."
    return page(f"{study.title}, run again", sections, lead, {"source": study.source}, origin=study.origin)


def _numbers(study: StudyRun) -> dict[str, Any]:
    """For JSON: plain numbers in the printed units."""
    return {
        "study": study.name,
        "source": study.source,
        "origin": study.origin.as_dict(),
        "left_out": list(study.left_out),
        "compared": [asdict(value) for value in study.compared],
        "page": None if study.page is None else str(study.page),
    }


def comparison_figure(judged: Sequence[ComparedValue]) -> FigureBlock | None:
    """How far each number is from the published one, by artefact; None where none is a number."""
    deviations: dict[str, list[tuple[float, str]]] = {}
    for value in judged:
        if isinstance(value.published, float) and isinstance(value.ours, float) and value.published:
            off = (value.ours - value.published) / abs(value.published)
            deviations.setdefault(value.artefact, []).append((off, value.verdict))
    if not deviations:
        return None
    caption = (
        "Each number beside the published one. What is allowed differs from number to number; the tables below say it. "
        "Numbers that cannot be checked, and statements without a number, are not drawn."
    )
    return FigureBlock(published_beside_ours(deviations), caption)


def compared_table(judged: Sequence[ComparedValue], caption: str = "", digits: int = 6) -> Table:
    """Published beside ours, with the verdict and its reason; what cannot be checked for one reason stands in one row."""
    unchecked: dict[tuple[str, str], list[str]] = {}
    for f in judged:
        if f.verdict == "cannot be checked":
            unchecked.setdefault((f.quantity, f.reason), []).append(f.artefact)
    rows: list[list[Cell]] = []
    for f in judged:
        artefacts = (
            unchecked.get((f.quantity, f.reason), [f.artefact]) if f.verdict == "cannot be checked" else [f.artefact]
        )
        if f.artefact == artefacts[0]:
            name = ", ".join(artefacts) if len(set(artefacts)) > 1 else f.artefact
            rows.append([name, f.quantity, _shown(f.published), _shown(f.ours), f.unit, Verdict(f.verdict, f.reason)])
    columns = ("artefact", "quantity", "published", "ours", "unit", "verdict")
    align = ("left", "left", "right", "right", "left", "left")
    return Table(columns, rows, align=align, caption=caption, digits=digits)


def _shown(value: float | str | None) -> Cell:
    text = getattr(value, "text", None)
    if text is None:
        return value
    digits = len(text.partition("e")[0].replace("-", "").replace(".", "").lstrip("0"))
    return number(float(text), digits) if "e" in text else text.replace("-", "−")
