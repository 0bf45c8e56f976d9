"""Short texts and notebook tables of objects: a title and rows of names and values, and a small figure."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Rows = Sequence[tuple[str, str]]

_TABLE = "border-collapse:collapse;font-size:0.9em"
_NAME = "text-align:left;padding:1px 1em 1px 0;font-weight:normal;opacity:0.75"
_VALUE = "text-align:left;padding:1px 0"


def as_text(title: str, rows: Rows) -> str:
    """The title, and below it a line for each ``(name, value)``, the values below one another."""
    width = max((len(name) for name, _ in rows), default=0)
    return "\n".join([f"<{title}>", *(f"  {name:<{width}}  {value}" for name, value in rows)])


def as_html(title: str, rows: Rows, figure: Callable[[], Figure] | None = None) -> str:
    """The same as a table for a notebook, with a figure below it.

    ``figure`` makes the figure; it is called here, so that objects that are never shown never load matplotlib.
    """
    cells = "".join(
        f'<tr><th style="{_NAME}">{escape(name)}</th><td style="{_VALUE}">{escape(value)}</td></tr>'
        for name, value in rows
    )
    below = "" if figure is None else f"<div>{as_svg(figure())}</div>"
    return f'<div><strong>{escape(title)}</strong><table style="{_TABLE}"><tbody>{cells}</tbody></table>{below}</div>'


def as_svg(figure: Figure) -> str:
    """A figure as SVG text to stand inside of HTML."""
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none"}):
        figure.savefig(text, format="svg", facecolor="white", metadata={"Date": None})
    return re.sub(r"^.*?(?=<svg)", "", text.getvalue(), count=1, flags=re.DOTALL)


def extent(values: Any, unit: str, factor: float = 1.0) -> str:
    """The range of an array, such as ``-9.8 … 9.8 mm``, times ``factor``; NaN is left out."""
    numbers = factor * np.asarray(values, dtype=float)
    numbers = numbers[np.isfinite(numbers)]
    if numbers.size == 0:
        return "no finite value"
    low, high = float(numbers.min()), float(numbers.max())
    return f"{low:.4g} {unit}" if low == high else f"{low:.4g} … {high:.4g} {unit}"


def listing(items: Sequence[str], limit: int = 4) -> str:
    """Items separated by commas, those beyond the first few counted."""
    more = len(items) - limit
    return ", ".join(items[:limit]) + (f" and {more} more" if more > 0 else "")
