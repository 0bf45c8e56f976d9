"""What the records of a fit cannot separate, as it is shown."""

from __future__ import annotations

from dampyr.identification.parameter_uncertainty.identifiability import Identifiability
from dampyr.phrases import counted
from dampyr.show.descriptions import Description, describe
from dampyr.show.table import Table
from dampyr.to_json import plain


@describe.register
def describe_identifiability(result: Identifiability) -> Description:
    """A row for each finding, and a table of them with the tests that would separate it."""
    rows = [(inseparable.kind, inseparable.brief) for inseparable in result.inseparable] or [
        ("", "these records separate what was fitted")
    ]
    return Description(
        f"Identifiability: {counted(len(result.inseparable), 'finding')}",
        rows,
        tables=[lambda: _tests(result)],
        data=lambda: dict(plain(result)),
    )


def _tests(result: Identifiability) -> Table:
    """One row a finding, and the test that would separate it."""
    rows = [[inseparable.words, inseparable.test] for inseparable in result.inseparable]
    return Table(("what the records cannot separate", "the test that would"), rows)
