"""The view of a result in a notebook: its rows, its table and its figure as HTML that stands alone."""

from __future__ import annotations

import io
import re
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.show.descriptions import Rows, description_of
from dampyr.show.figures.style import on_white
from dampyr.show.figures.symbols import in_law_words
from dampyr.show.table import Table, Verdict
from dampyr.show.text import title_and_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_ROWS = 24  # of a table

_TABLE = "border-collapse:collapse;font-size:0.9em"
_NAME = "text-align:left;padding:1px 1em 1px 0;font-weight:normal;opacity:0.75"
_VALUE = "text-align:left;padding:1px 0"
_HEAD = "padding:3px 0.8em 1px 0;font-weight:normal;opacity:0.75;border-bottom:1px solid"
_CELL = "padding:1px 0.8em 1px 0"


def as_html(result: Any) -> str:
    """Title and rows of a result, below them its table and its figure, with the mark of its origin."""
    description = description_of(result)
    figure = description.figure() if description.figure else None
    origin = getattr(result, "origin", None)
    if figure is not None and origin is not None:
        origin.stamp(figure)
    return rows_as_html(
        *title_and_rows(result), table=description.tables[0]() if description.tables else None, figure=figure
    )


def rows_as_html(
    title: str,
    rows: Rows,
    table: Table | None = None,
    figure: Figure | None = None,
) -> str:
    """A title, rows of names and values, a table of its own columns, and a figure below it."""
    cells = "".join(
        f'<tr><th style="{_NAME}">{escape(name)}</th><td style="{_VALUE}">{escape(value)}</td></tr>'
        for name, value in rows
    )
    columns = "" if table is None else _table_as_html(table)
    below = "" if figure is None else f"<div>{as_svg(figure)}</div>"
    head = f'<table style="{_TABLE}"><tbody>{cells}</tbody></table>' if rows else ""
    return f"<div><strong>{escape(title)}</strong>{head}{columns}{below}</div>"


def _table_as_html(table: Table) -> str:
    columns, rows = table.heads, table.rows
    numeric = [all(not isinstance(row[k], str | Verdict) for row in rows) for k in range(len(columns))]
    sides = ["right" if is_numeric else "left" for is_numeric in numeric]
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
    return value.kind if isinstance(value, Verdict) else str(value)


def as_svg(figure: Figure) -> str:
    """A figure as SVG text to stand inside of HTML; the same figure gives the same text."""
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "dampyr"}), on_white(figure):
        in_law_words(figure).savefig(text, format="svg", facecolor="white", metadata={"Date": None})
    return re.sub(r"^.*?(?=<svg)", "", text.getvalue(), count=1, flags=re.DOTALL)
