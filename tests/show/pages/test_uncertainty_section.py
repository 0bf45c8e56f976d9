"""The standard uncertainty of each channel over the records that state it."""

from dataclasses import replace

import pytest
from tests.show.fit_examples import records

from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.show.pages.blocks import Text
from dampyr.show.pages.uncertainty_section import uncertainty_section
from dampyr.show.table import Table

RECORDS = records((0.0,), 3)
STATED = [
    replace(record, uncertainty={
        "force": ChannelUncertainty({"load cell": 3.0 * k, "amplifier": 4.0 * k}),
        "displacement": ChannelUncertainty({"encoder": 1e-6 * k, "lost counts": 0.0}),
    })
    for k, record in zip((1.0, 2.0, 4.0), RECORDS, strict=True)
]  # fmt: skip


def test_a_row_holds_median_least_and_greatest_in_the_units_that_people_read() -> None:
    section = uncertainty_section(STATED)
    assert section is not None
    table = section.blocks[1]
    assert isinstance(table, Table)
    rows = {row[0]: list(row[1:]) for row in table.rows}
    assert list(rows) == ["displacement", "force"]
    assert rows["force"][:4] == ["N", *map(pytest.approx, (10.0, 5.0, 20.0))]  # 3, 4 and 5 times k
    assert rows["force"][4:] == ["amplifier", "amplifier 8, load cell 6"]
    assert rows["displacement"][:4] == ["µm", *map(pytest.approx, (2.0, 1.0, 4.0))]
    assert rows["displacement"][4:] == ["encoder", "encoder 2"]  # a part of nothing is left out


def test_records_that_state_none_are_counted() -> None:
    section = uncertainty_section([*STATED[:1], *RECORDS[1:]])
    assert section is not None
    text = section.blocks[0]
    assert isinstance(text, Text)
    assert "2 of 3 records state none." in text.text
    assert uncertainty_section(RECORDS) is None
