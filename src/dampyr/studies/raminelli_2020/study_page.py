"""Page of the study: a summary of every artefact, the parts in the order of the text, slips, and what was left out."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from dampyr.show.pages.blocks import Block, Section, Text
from dampyr.show.pages.html_page import page, write_html
from dampyr.show.table import Cell, Table, Verdict
from dampyr.studies._compared_value import ComparedValue, Erratum, overall
from dampyr.studies._study_run import comparison_figure
from dampyr.studies.raminelli_2020.study import Study, artefacts_table

SOURCE = (
    "J. G. Raminelli, Plataforma de testes dinâmicos para amortecedores magneto-reológicos e representação "
    "através de modelos de "
    "histerese, master's dissertation, UTFPR, Cornélio Procópio, 2020"
)
DATA = "Labcontrol (UTFPR), A. N. Vargas: data of the shaking table with MR-damper, v1.0.3, 2021, doi 10.5281/zenodo.4445334"


def write(study: Study, out: Path) -> Study:
    """``reproduce.html`` and ``reproduce.json`` in ``out``; returns the study with its page."""
    with_page = replace(study, page=write_html(out / "reproduce.html", html(study)))
    text = json.dumps(with_page.as_dict(), indent=2, ensure_ascii=False, allow_nan=False)
    (out / "reproduce.json").write_text(text + "\n", encoding="utf-8")
    return with_page


def html(study: Study) -> str:
    """The whole page."""
    sections = [Section("Summary", summary(study)), *(Section(part.title, part.blocks) for part in study.parts)]
    if study.errata:
        sections.append(Section("Slips of the text", [errata(study.errata)]))
    provenance = {
        "dissertation": SOURCE,
        "data": f"{DATA}; read from {study.data.name}" if study.data else "the measured files were not there",
    }
    return page(
        "Raminelli (2020), run again", sections, "Every published number beside ours, with a verdict.", provenance
    )


def summary(study: Study) -> list[Block]:
    """One line for each table, equation, error and figure."""
    verdicts = [Verdict(overall(judged), _count_and_reason(judged)) for judged in study.artefacts.values()]
    table = artefacts_table(study)
    rows = [[*row[:-1], verdict] for row, verdict in zip(table.rows, verdicts, strict=True)]
    text = (
        "A verdict follows from the two numbers and the tolerance beside it. An artefact differs where one of "
        "its numbers does; the reason "
        "is the first such number's, and the sections below have all. Numbers of tables are in the printed units."
    )
    figure = comparison_figure(study.compared)
    blocks: list[Block] = [Text(text), *([figure] if figure else []), replace(table, rows=rows, caption="")]
    if study.left_out:
        blocks.append(Verdict("cannot be checked", "left out: " + "; ".join(study.left_out)))
    return blocks


def _count_and_reason(judged: Sequence[ComparedValue]) -> str:
    """Counts, and the first reason of the verdict."""
    kind = overall(judged)
    of = [f for f in judged if f.verdict == kind]
    count = f"{len(of)} of {len(judged)}: " if len(judged) > 1 else ""
    return f"{count}{of[0].quantity}, {of[0].reason}"


def errata(entries: Sequence[Erratum]) -> Table:
    """Slips: printed, what it should be, why."""
    rows: list[list[Cell]] = [[e.place, e.printed, e.correct, e.reason] for e in entries]
    return Table(("where", "printed", "should be", "because"), rows)
