"""A table and what its cells may hold; verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

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

    Parameters
    ----------
    columns
        The names.
    rows
        Their cells, as many as there are columns; None is shown as a dash.
    units
        Stand under the names, one for each column ("" for none); by default there are none.
    align
        "left" or "right" for each column; by default numbers stand right and anything else left.
    caption
        Says what it is.
    notes
        Sentences that explain its columns.
    digits
        Significant digits of a number.

    Examples
    --------
    >>> from dampyr import show
    >>> show.Table(("input", "force"), [[0.0, 110.2], [1.98, 480.9]], ("V", "N")).heads
    ['input [V]', 'force [N]']
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
        for name, per_column in (("units", self.units), ("align", self.align)):
            if per_column and len(per_column) != width:
                raise InputError(f"a table of {width} columns has {len(per_column)} {name}; give one for each column")
        for number, row in enumerate(self.rows, 1):
            if len(row) != width:
                raise InputError(f"row {number} of a table has {len(row)} cells; its columns are {width}")

    def without(self, *names: str) -> Table:
        """The table less the columns of these names."""
        retained = [k for k, name in enumerate(self.columns) if name not in names]

        def of(cells: Sequence[Any]) -> list[Any]:
            return [cells[k] for k in retained] if cells else []

        rows = [of(row) for row in self.rows]
        return replace(self, columns=of(self.columns), rows=rows, units=of(self.units), align=of(self.align))

    @property
    def heads(self) -> list[str]:
        """The names of the columns with their units, such as ``kx [N s/mm]``."""
        units = self.units or [""] * len(self.columns)
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(self.columns, units, strict=True)]
