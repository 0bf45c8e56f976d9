"""A table and what its cells may hold; verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from dampyr.errors import InputError
from dampyr.shown import Shown

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
class Table(Shown):
    """Rows under named columns, sortable by the reader.

    ``caption`` says what it is, and ``notes``, sentences, explain its columns. ``units`` stand under the names ("" for none);
    numbers get ``digits`` significant digits and are aligned right unless ``align`` says "left" or "right" for a column. None
    is shown as a dash.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    units: Sequence[str] = ()
    align: Sequence[str] = ()
    caption: str = ""
    notes: Sequence[str] = ()
    digits: int = 5

    def __post_init__(self) -> None:
        width = len(self.columns)
        for name, given in (("units", self.units), ("align", self.align)):
            if given and len(given) != width:
                raise InputError(f"a table of {width} columns has {len(given)} {name}; give one for each column")
        for number, row in enumerate(self.rows, 1):
            if len(row) != width:
                raise InputError(f"row {number} of a table has {len(row)} cells; its columns are {width}")

    @property
    def heads(self) -> list[str]:
        """The names of the columns with their units, such as ``kx [N s/mm]``."""
        units = self.units or [""] * len(self.columns)
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(self.columns, units, strict=True)]
