"""Building blocks of a page: sections of text, tables, figures and verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from dampyr.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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


@dataclass(frozen=True)
class Text:
    """One or more paragraphs of plain text; an empty line parts them."""

    text: str


@dataclass(frozen=True)
class Table:
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


@dataclass(frozen=True)
class FigureBlock:
    """A figure with its caption; ``alt`` says in words what it shows, for those who cannot see it."""

    figure: Figure
    caption: str
    alt: str = ""


Block = Text | Table | FigureBlock | Verdict


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it."""

    title: str
    blocks: Sequence[Block]


def sentence(text: str) -> str:
    """A clause, such as a finding or a note, with a capital and a full stop; a name at its head keeps its letters."""
    first = text.partition(" ")[0]
    head = text if {".", "_", "@"} & set(first) else text[:1].upper() + text[1:]
    return f"{head}."
