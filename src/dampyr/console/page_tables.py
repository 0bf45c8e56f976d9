"""Tables as the pages draw them."""

from __future__ import annotations

from typing import Any

from dampyr.show.table import Table
from dampyr.to_json import plain


def page_table(table: Table) -> dict[str, Any]:
    """A table as plain values: caption, notes, columns, the unit of each ("" for none), rows."""
    return {
        "caption": table.caption,
        "notes": list(table.notes),
        "columns": list(table.columns),
        "units": list(table.units or [""] * len(table.columns)),
        "rows": plain([list(row) for row in table.rows]),
    }
