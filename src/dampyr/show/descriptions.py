"""What a result shows, found by its type."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import singledispatch
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from dampyr.show.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Rows = Sequence[tuple[str, str]]

_loaded: set[type] = set()  # whose descriptions were looked for


@dataclass(frozen=True)
class DataFrameColumns:
    """What a data frame holds: columns by name in SI units, such as ``velocity_m_per_s``, and what its rows are called."""

    columns: Mapping[str, Any]
    index: Sequence[Any] | None = None
    index_name: str = ""


@dataclass(frozen=True)
class Description:
    """What a result shows: text, notebook view, figure, tables, JSON and data frame are functions of it.

    The ``title`` begins with the name of the class. ``rows`` are ``(name, value)``, values with their units; ``verdict`` says
    in whole sentences how it came out. Each of ``tables`` makes a `Table` in the units that people read; a notebook and a
    terminal show the first, and the latter the others where details are asked for. ``figure`` draws the figure that stands for
    the result, without the mark of its origin. ``data`` makes what JSON holds, numbers by name in SI units, and ``frame`` what
    a data frame holds; without them JSON holds the fields of the result, and a data frame the first table. All of these are
    made when they are shown, so that a text needs none. The origin and the findings are the result's own.
    """

    title: str
    rows: Rows = ()
    verdict: Sequence[str] = ()
    tables: Sequence[Callable[[], Table]] = ()
    figure: Callable[[], Figure | None] | None = None
    data: Callable[[], Mapping[str, Any]] | None = None
    frame: Callable[[], DataFrameColumns] | None = None


@singledispatch
def describe(result: Any) -> Description:
    """The description registered for the type of ``result`` (``@describe.register``); `description_of` finds its file."""
    raise TypeError(f"{type(result).__name__} has no description; register one with dampyr.show.descriptions.describe")


def description_of(result: Any) -> Description:
    """What ``result`` shows; TypeError where nothing describes its type."""
    load_descriptions(type(result))
    return describe(result)


def load_descriptions(kind: type) -> None:
    """Load the files that describe ``kind`` and its bases: dampyr.show.PACKAGE.MODULE for dampyr.PACKAGE. … .MODULE."""
    if kind in _loaded:
        return
    _loaded.add(kind)
    for base in kind.__mro__:
        root, _, rest = base.__module__.partition(".")
        package, _, inner = rest.partition(".")
        if root == "dampyr" and inner and package != "show":
            name = f"dampyr.show.{package}.{inner.rpartition('.')[2]}"
            if find_spec(f"dampyr.show.{package}") and find_spec(name):
                import_module(name)
