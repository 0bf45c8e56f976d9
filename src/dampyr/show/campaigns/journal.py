"""What the journal of a campaign shows."""

from __future__ import annotations

from collections import Counter

from dampyr.campaigns.journal import Journal
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.table import Cell, Table


@describe.register
def describe_journal(journal: Journal) -> Description:
    """Folder, origin, how many tests are in which state, and how many events; the tests in a table."""
    states = Counter(entry.state for entry in journal.tests())
    return Description(
        f"Journal of {journal.get_metadata('name')!r}",
        [
            ("folder", journal.path.parent.name),
            ("origin", journal.origin.kind),
            ("tests", ", ".join(f"{count} {state}" for state, count in states.items()) or "none"),
            ("events", str(len(journal.events()))),
        ],
        tables=[lambda: _table(journal)],
        frame=lambda: _columns(journal),
    )


def _table(journal: Journal) -> Table:
    """The tests in their order with their states."""
    rows: list[list[Cell]] = [[entry.name, entry.state, entry.attempt, entry.reason] for entry in journal.tests()]
    return Table(("test", "state", "attempt", "reason"), rows)


def _columns(journal: Journal) -> DataFrameColumns:
    """The tests in their order: state, attempt and reason."""
    entries = journal.tests()
    columns = {name: [getattr(entry, name) for entry in entries] for name in ("state", "attempt", "reason")}
    return DataFrameColumns(columns, [entry.name for entry in entries], "test")
