"""The page of the history of specimens: the table, the trends, and what is in doubt in their records."""

from __future__ import annotations

from dampyr.records.specimen_history import SpecimenHistories
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.pages.html_page import page
from dampyr.show.records.specimen_history import history_table, trend_figure, trend_table


def html(result: SpecimenHistories, *, call: str = "") -> str:
    """The page of the history of specimens."""
    sections = [Section("Specimens", [history_table(result)])]
    figure = trend_figure(result)
    if figure is not None:
        blocks: list[Block] = [
            FigureBlock(figure, "Equal tests of a specimen, over the days since the first."),
            trend_table(result),
        ]
        sections.append(Section("Trends", blocks))
    if result.findings:
        sections.append(Section("To look at", [Text("\n\n".join(finding.sentence for finding in result.findings))]))
    return page("Specimens", sections, subtitle=", ".join(result.folders), origin=result.origin, call=call)
