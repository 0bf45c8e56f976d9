"""Short texts and notebook tables of objects: a title and rows of names and values, a table, and a small figure."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Rows = Sequence[tuple[str, str]]
Columns = Sequence[str]
Summary = tuple[str, Rows]
Table = tuple[Columns, Sequence[Sequence[Any]]]

MAX_LINES = 13  # of a text, below its title
MAX_LETTERS = 88  # of a value in a text; a notebook shows it whole
MAX_ROWS = 24  # of a table in a notebook

_TABLE = "border-collapse:collapse;font-size:0.9em"
_NAME = "text-align:left;padding:1px 1em 1px 0;font-weight:normal;opacity:0.75"
_VALUE = "text-align:left;padding:1px 0"
_HEAD = "padding:3px 0.8em 1px 0;font-weight:normal;opacity:0.75;border-bottom:1px solid"
_CELL = "padding:1px 0.8em 1px 0"


class Representation:
    """A class whose objects show themselves.

    ``print`` and a prompt show the title and the rows of `_summary`; a notebook shows them as a table, with the rows of
    `_table` and the figure of `_small_figure` below where a class has them. A dataclass is declared with ``repr=False``, or it
    would have a repr of its own.
    """

    __slots__ = ()

    def _summary(self) -> Summary:
        """The title, and the ``(name, value)`` of each row, values with their units."""
        raise NotImplementedError

    def _table(self) -> Table | None:
        """The heads of columns, with units, and the rows below them."""
        return None

    def _small_figure(self) -> Figure | None:
        """A figure, made when it is shown, so that objects that are never shown never load matplotlib."""
        return None

    def _whole_summary(self) -> Summary:
        """The summary, before it what an ``origin`` that is not measured says, and the worst of the ``findings``."""
        title, rows = self._summary()
        origin = getattr(self, "origin", None)
        of_origin = [("origin", origin.notice)] if origin is not None and origin.notice else []
        return title, [*of_origin, *findings_row(getattr(self, "findings", ())), *rows]

    def __repr__(self) -> str:
        return as_text(*self._whole_summary())

    def _repr_html_(self) -> str:
        figure = self._small_figure()
        if figure is not None:
            origin = getattr(self, "origin", None)
            figure = figure if origin is None else origin.stamp(figure)
        return as_html(*self._whole_summary(), table=self._table(), figure=figure)


def findings_row(findings: Sequence[Any]) -> Rows:
    """The worst of some `dampyr.findings` as a row, and one on how many more there are; no row where there are none."""
    if not findings:
        return []
    more = len(findings) - 1
    worst = ("note" if findings[0].severity == "note" else "look at", str(findings[0]))
    return [worst, ("", f"and {counted(more, 'more finding')}")] if more else [worst]


def as_text(title: str, rows: Rows) -> str:
    """The title, and below it a line for each ``(name, value)``, the values below one another."""
    shown = (
        list(rows)
        if len(rows) <= MAX_LINES
        else [*rows[: MAX_LINES - 1], ("", f"and {len(rows) - MAX_LINES + 1} more")]
    )
    width = max((len(name) for name, _ in shown), default=0)
    return "\n".join([f"<{title}>", *(f"  {name:<{width}}  {_one_line(value)}" for name, value in shown)])


def _one_line(value: str) -> str:
    text = " ".join(value.split())
    return text if len(text) <= MAX_LETTERS else text[: MAX_LETTERS - 2].rstrip() + " …"


def as_html(title: str, rows: Rows, table: Table | None = None, figure: Figure | None = None) -> str:
    """The same as a table for a notebook, with a table of its own columns and a figure below it."""
    cells = "".join(
        f'<tr><th style="{_NAME}">{escape(name)}</th><td style="{_VALUE}">{escape(value)}</td></tr>'
        for name, value in rows
    )
    columns = "" if table is None else _columns_as_html(*table)
    below = "" if figure is None else f"<div>{as_svg(figure)}</div>"
    head = f'<table style="{_TABLE}"><tbody>{cells}</tbody></table>' if rows else ""
    return f"<div><strong>{escape(title)}</strong>{head}{columns}{below}</div>"


def _columns_as_html(columns: Columns, rows: Sequence[Sequence[Any]]) -> str:
    numeric = [all(not isinstance(row[k], str) for row in rows) for k in range(len(columns))]
    sides = ["right" if each else "left" for each in numeric]
    head = "".join(
        f'<th style="{_HEAD};text-align:{side}">{escape(name)}</th>' for name, side in zip(columns, sides, strict=True)
    )
    body = "".join(
        "<tr>"
        + "".join(
            f'<td style="{_CELL};text-align:{side}">{escape(_cell(value))}</td>'
            for value, side in zip(row, sides, strict=True)
        )
        + "</tr>"
        for row in rows[:MAX_ROWS]
    )
    more = f"<div>and {len(rows) - MAX_ROWS} more rows</div>" if len(rows) > MAX_ROWS else ""
    return f'<table style="{_TABLE}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}'


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return "–"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"
    return str(value)


def as_svg(figure: Figure) -> str:
    """A figure as SVG text to stand inside of HTML; the same figure gives the same text."""
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "dampyr"}):
        figure.savefig(text, format="svg", facecolor="white", metadata={"Date": None})
    return re.sub(r"^.*?(?=<svg)", "", text.getvalue(), count=1, flags=re.DOTALL)


def data_frame(columns: Mapping[str, Any], index: Sequence[Any] | None = None, index_name: str = "") -> Any:
    """A ``pandas.DataFrame`` of these columns; :class:`~dampyr.errors.InputError` where pandas is not installed."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise InputError(
            "a data frame needs pandas, which is not installed; install it with: python -m pip install pandas"
        ) from None
    frame = DataFrame(dict(columns), index=None if index is None else list(index))
    return frame.rename_axis(index_name) if index_name else frame


def column_name(quantity: str, unit: str) -> str:
    """The name of a column in SI units, such as ``velocity_m_per_s``."""
    spelled = unit.replace("^", "").replace("/", "_per_").replace(" ", "_").removeprefix("1_per_")
    if unit.startswith("1/"):
        spelled = f"per_{spelled}"
    return f"{quantity}_{spelled}" if unit else quantity


def extent(values: Any, unit: str, factor: float = 1.0) -> str:
    """The range of an array, such as ``-9.8 … 9.8 mm``, times ``factor``; NaN is left out."""
    numbers = factor * np.asarray(values, dtype=float)
    numbers = numbers[np.isfinite(numbers)]
    if numbers.size == 0:
        return "no finite value"
    low, high = float(numbers.min()), float(numbers.max())
    return (f"{low:.4g} {unit}" if low == high else f"{low:.4g} … {high:.4g} {unit}").rstrip()


def rounded(value: float, digits: int) -> str:
    """A number to so many digits, without an exponent from a thousandth to a million: ``110`` and not ``1.1e+02``."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.15g}" if math.isfinite(value) and 1e-3 <= abs(value) < 1e6 else text


def listing(items: Sequence[str], limit: int = 4) -> str:
    """Items separated by commas, those beyond the first few counted."""
    more = len(items) - limit
    return ", ".join(items[:limit]) + (f" and {more} more" if more > 0 else "")


def sentence(text: str) -> str:
    """A clause, such as a finding or a note, with a capital and a full stop; a name at its head keeps its letters."""
    first = text.partition(" ")[0]
    return full_stop(text if {".", "_", "@"} & set(first) else text[:1].upper() + text[1:])


def full_stop(text: str) -> str:
    """A clause with its full stop; a question has its mark."""
    return text if text.endswith("?") else f"{text}."


def counted(number: int, noun: str) -> str:
    """Such as ``1 record`` and ``3 records``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def percent(ratio: float | None) -> str:
    """A ratio in percent, such as ``8.7 %``; a dash where there is none."""
    return "–" if ratio is None or np.isnan(ratio) else f"{100 * ratio:.3g} %"
