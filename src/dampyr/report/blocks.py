"""Building blocks of a page: sections of text, tables, figures and verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from dampyr.errors import InputError
from dampyr.findings import Finding
from dampyr.representation import Representation, Summary, counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from dampyr.representation import Table as ColumnsAndRows

Kind = Literal["agrees", "differs", "cannot be checked", "passed", "failed", "not judged"]


@dataclass(frozen=True)
class Verdict:
    """A judgement and its reason; stands alone or in a cell of a table."""

    kind: Kind
    text: str = ""

    def __post_init__(self) -> None:
        if self.kind not in get_args(Kind):
            raise InputError(f"verdict {self.kind!r} is not known; choose from {', '.join(get_args(Kind))}")


Cell = str | float | int | bool | Verdict | None
"""What a cell of a table may hold."""


@dataclass(frozen=True, repr=False)
class Text(Representation):
    """One or more paragraphs of plain text; an empty line parts them."""

    text: str

    def _summary(self) -> Summary:
        return f"Text of {counted(len(self.paragraphs), 'paragraph')}", [("", each) for each in self.paragraphs[:4]]

    @property
    def paragraphs(self) -> list[str]:
        """The paragraphs."""
        return [part.strip() for part in self.text.split("\n\n") if part.strip()]


@dataclass(frozen=True, repr=False)
class Table(Representation):
    """Rows under named columns, sortable by the reader.

    ``units`` stand under the names ("" for none); numbers get ``digits`` significant digits and are aligned
    right unless ``align`` says "left" or "right" for a column. None is shown as a dash.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    units: Sequence[str] = ()
    align: Sequence[str] = ()
    caption: str = ""
    digits: int = 5

    def __post_init__(self) -> None:
        width = len(self.columns)
        for name, given in (("units", self.units), ("align", self.align)):
            if given and len(given) != width:
                raise InputError(f"a table of {width} columns has {len(given)} {name}; give one for each column")
        for number, row in enumerate(self.rows, 1):
            if len(row) != width:
                raise InputError(f"row {number} of a table has {len(row)} cells; its columns are {width}")

    def _summary(self) -> Summary:
        rows = [("columns", ", ".join(self._heads())), ("rows", str(len(self.rows))), ("caption", self.caption)]
        return "Table", [row for row in rows if row[1]]

    def _table(self) -> ColumnsAndRows:
        rows = [[cell.kind if isinstance(cell, Verdict) else cell for cell in row] for row in self.rows]
        return self._heads(), rows

    def _heads(self) -> list[str]:
        units = self.units or [""] * len(self.columns)
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(self.columns, units, strict=True)]


@dataclass(frozen=True, repr=False)
class FigureBlock(Representation):
    """A figure with its caption; ``alt`` says in words what it shows, for those who cannot see it."""

    figure: Figure
    caption: str
    alt: str = ""

    def _small_figure(self) -> Figure:
        return self.figure

    def _summary(self) -> Summary:
        width, height = self.figure.get_size_inches()
        return f"FigureBlock, {width:.3g} × {height:.3g} in", [("caption", self.caption)]


Block = Text | Table | FigureBlock | Verdict
"""A part of a section of a page."""


@dataclass(frozen=True, repr=False)
class Section(Representation):
    """A heading and what stands under it."""

    title: str
    blocks: Sequence[Block]

    def _summary(self) -> Summary:
        return f"Section {self.title!r}", [(type(block).__name__, _first_words(block)) for block in self.blocks]


def _first_words(block: Block) -> str:
    if isinstance(block, Verdict):
        return block.kind
    return block.text if isinstance(block, Text) else block.caption


def to_look_at(findings: Iterable[Finding]) -> list[Block]:
    """The findings, a paragraph each; nothing where there are none."""
    texts = [finding.sentence for finding in findings]
    return [Text("\n\n".join(("Before you use the numbers:", *texts)))] if texts else []
