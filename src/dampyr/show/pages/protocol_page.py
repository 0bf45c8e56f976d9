"""The page of a protocol that was run: criterion, limit, value and verdict, and all figures."""

from __future__ import annotations

from dataclasses import replace

from dampyr.campaigns.protocol_result import ProtocolResult
from dampyr.phrases import counted, sentence
from dampyr.show.campaigns.protocol_result import figure_table, in_words, judged_table
from dampyr.show.pages.blocks import Block, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.table import Table, Verdict


def html(result: ProtocolResult, *, call: str = "") -> str:
    """The page of what `dampyr.campaigns.judge_protocol` gives."""
    short: list[Block] = [Verdict(result.verdict, sentence(in_words(result)))]
    short += [Text(sentence(reason)) for reason in result.reasons]
    short += to_look_at(result.findings)
    sections = [Section("In short", short)]
    if result.judged:
        sections.append(Section("Criteria", [_with_marks(replace(judged_table(result), caption="By criterion."))]))
    sections.append(Section("Figures", [replace(figure_table(result), caption="All figures, judged or not.")]))
    return page(
        f"Protocol {result.kind}",
        sections,
        subtitle=f"{counted(len(result.records), 'record')}, {counted(len(result.figures), 'figure')}.",
        provenance={"protocol": result.records[0].provenance["protocol"]},
        call=call,
        origin=result.origin,
    )


def _with_marks(table: Table) -> Table:
    k = list(table.columns).index("verdict")
    return replace(table, rows=[[*row[:k], Verdict(row[k]), *row[k + 1 :]] for row in table.rows])  # type: ignore[arg-type]
