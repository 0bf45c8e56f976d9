"""Building blocks of a page: sections of text, tables, figures and verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dampyr.findings import Finding
from dampyr.phrases import counted
from dampyr.show.descriptions import Description, describe
from dampyr.show.plots import plots
from dampyr.show.table import Table, Verdict
from dampyr.shown import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Text(Shown):
    """One or more paragraphs of plain text; an empty line parts them."""

    text: str

    @property
    def paragraphs(self) -> list[str]:
        """The paragraphs."""
        return [part.strip() for part in self.text.split("\n\n") if part.strip()]


@dataclass(frozen=True, repr=False)
class FigureBlock(Shown):
    """A figure with its caption; ``alt`` says in words what it shows, for those who cannot see it."""

    figure: Figure
    caption: str
    alt: str = ""


Block = Text | Table | FigureBlock | Verdict
"""A part of a section of a page."""


@dataclass(frozen=True, repr=False)
class Section(Shown):
    """A heading and what stands under it."""

    title: str
    blocks: Sequence[Block]


def to_look_at(findings: Iterable[Finding]) -> list[Block]:
    """The findings, a paragraph each; nothing where there are none."""
    texts = [finding.sentence for finding in findings]
    return [Text("\n\n".join(("Before you use the numbers:", *texts)))] if texts else []


@describe.register
def describe_text(text: Text) -> Description:
    """Its first paragraphs."""
    return Description(
        f"Text of {counted(len(text.paragraphs), 'paragraph')}", [("", paragraph) for paragraph in text.paragraphs[:4]]
    )


@describe.register
def describe_table(table: Table) -> Description:
    """Columns, number of rows, caption, and its rows."""
    rows = [("columns", ", ".join(table.heads)), ("rows", str(len(table.rows))), ("caption", table.caption)]
    return Description("Table", [row for row in rows if row[1]], tables=[lambda: table])


@describe.register
def describe_figure(block: FigureBlock) -> Description:
    """Its size, its caption and the figure."""
    width, height = block.figure.get_size_inches()
    title = f"FigureBlock, {width:.3g} × {height:.3g} in"
    return Description(title, [("caption", block.caption)], figure=lambda: block.figure)


plots.register(FigureBlock, lambda block: None)  # its figure is drawn already


@describe.register
def describe_section(section: Section) -> Description:
    """Its blocks."""
    return Description(
        f"Section {section.title!r}", [(type(block).__name__, _first_words(block)) for block in section.blocks]
    )


def _first_words(block: Block) -> str:
    if isinstance(block, Verdict):
        return block.kind
    return block.text if isinstance(block, Text) else block.caption
