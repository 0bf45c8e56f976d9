"""What a campaign and its tests show."""

from __future__ import annotations

from collections import Counter

from dampyr.campaigns.campaign import Campaign, Test
from dampyr.phrases import counted, listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.table import Table


@describe.register
def describe_test(test: Test) -> Description:
    """The step that it comes from, its place, and whether its drive is learned."""
    return Description(
        f"Test {test.name!r}",
        [
            ("step", f"{test.step_number}, {test.words}"),
            ("place", f"{test.number} as written, repeat {test.repeat}"),
            *([("drive", "learned before it is recorded")] if test.learn else []),
        ],
    )


@describe.register
def describe_campaign(campaign: Campaign) -> Description:
    """How many tests of each kind, their order, and what stands in the header; the tests in a table."""
    header, kinds = campaign.header, Counter(test.kind for test in campaign.tests)
    of_kinds = listing([counted(n, kind.replace("_", " ")) for kind, n in kinds.items()])
    rows = [
        ("tests", f"{len(campaign.tests)}: {of_kinds}"),
        ("order", header.order + (f", seed {header.seed}" if header.order == "random" else "")),
        ("rest", f"{header.rest_between:g} s between tests"),
        ("operator", header.operator),
        ("note", header.note),
        ("session", header.measurement_session),
        ("specimen", header.specimen),
        ("digest", campaign.digest),
    ]
    return Description(
        f"Campaign {header.name!r}",
        [row for row in rows if row[1]],
        tables=[lambda: Table(("test", "what it does"), [[test.name, test.words] for test in campaign.tests])],
        frame=lambda: _columns(campaign),
    )


def _columns(campaign: Campaign) -> DataFrameColumns:
    """The tests in the order in which they run."""
    names = ("number", "step_number", "kind", "repeat", "words")
    columns = {name: [getattr(test, name) for test in campaign.tests] for name in names}
    return DataFrameColumns(columns, [test.name for test in campaign.tests], "test")
