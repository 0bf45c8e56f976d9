"""The text of a result, as ``print`` and a prompt show it."""

from __future__ import annotations

from typing import Any

from dampyr.findings import findings_row
from dampyr.show.descriptions import Rows, description_of

MAX_LINES = 13  # of a text, below its title
MAX_LETTERS = 88  # of a value in a text; a notebook shows it whole


def title_and_rows(result: Any) -> tuple[str, Rows]:
    """Title and rows of a result; first what an origin that is not measured says, and the worst of its findings."""
    description = description_of(result)
    origin = getattr(result, "origin", None)
    of_origin = [("origin", origin.notice)] if origin is not None and origin.notice else []
    return description.title, [*of_origin, *findings_row(getattr(result, "findings", ())), *description.rows]


def as_text(result: Any) -> str:
    """The title of a result, and below it its rows."""
    return rows_as_text(*title_and_rows(result))


def rows_as_text(title: str, rows: Rows) -> str:
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
