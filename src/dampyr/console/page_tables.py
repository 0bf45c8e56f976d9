"""Tables as the pages draw them."""

from __future__ import annotations

from typing import Any

from dampyr.show.pages.typography import as_words
from dampyr.show.table import Table
from dampyr.to_json import plain


def page_table(table: Table) -> dict[str, Any]:
    """A table as plain values: caption, notes, columns, the unit of each ("" for none), digits of numbers, rows.

    Parameters and laws are as on paper.
    """
    return {
        "caption": as_words(table.caption),
        "notes": [as_words(note) for note in table.notes],
        "columns": [as_words(name) for name in table.columns],
        "units": list(table.units or [""] * len(table.columns)),
        "digits": table.digits,
        "rows": plain([[as_words(cell) if isinstance(cell, str) else cell for cell in row] for row in table.rows]),
    }
