"""What the records of a campaign show."""

from __future__ import annotations

import numpy as np

from dampyr.campaigns.recorded_campaign import RecordedCampaign
from dampyr.findings import as_dicts
from dampyr.input_kinds import NO_INPUT, unit_of
from dampyr.phrases import counted
from dampyr.show.descriptions import Description, describe
from dampyr.show.table import Cell, Table


@describe.register
def describe_recorded(campaign: RecordedCampaign) -> Description:
    """The folder, the number of records and how long they last; a row a record."""
    records = campaign.records
    return Description(
        f"RecordedCampaign {str(campaign.folder)!r}",
        [
            ("records", counted(len(records), "record")),
            ("duration", f"{sum(record.duration for record in records):.4g} s"),
        ],
        tables=[lambda: record_table(campaign)],
        data=lambda: {
            "folder": str(campaign.folder),
            "origin": campaign.origin.as_dict(),
            "findings": as_dicts(campaign.findings),
            "records": [record.name for record in records],
        },
    )


def record_table(campaign: RecordedCampaign) -> Table:
    """Input, range of the displacement and of the force, and duration of each record."""
    rows: list[list[Cell]] = [
        [
            record.name, record.input_value, 1e3 * float(np.ptp(record.displacement)), float(record.force.min()),
            float(record.force.max()), record.duration,
        ]
        for record in campaign.records
    ]  # fmt: skip
    kinds = {record.input for record in campaign.records}
    table = Table(
        ("record", "input", "peak to peak", "lowest force", "highest force", "duration"),
        rows,
        ("", unit_of(campaign.records[0].input if campaign.records else None), "mm", "N", "N", "s"),
        digits=4,
    )
    return table.without("input") if kinds == {NO_INPUT} else table
