"""What the records of a campaign show: a row a record, in the units that people read."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.campaigns.recorded_campaign import RecordedCampaign
from dampyr.records import Record
from dampyr.show.campaigns.recorded_campaign import record_table
from dampyr.show.descriptions import description_of

T = np.linspace(0.0, 4.0, 401)


@pytest.fixture
def campaign(tmp_path: Path) -> RecordedCampaign:
    recorded = RecordedCampaign(tmp_path)
    recorded.__dict__["records"] = tuple(
        Record(T[:n], a * np.sin(2 * np.pi * T[:n]), 50.0 * a * np.cos(2 * np.pi * T[:n]), voltage=u, name=f"{u:g} V")
        for n, a, u in ((401, 0.01, 0.0), (201, 0.02, 1.98))
    )
    return recorded


def test_a_row_holds_input_stroke_forces_and_duration(campaign: RecordedCampaign) -> None:
    table = record_table(campaign)
    assert table.heads == [
        "record", "input [V]", "peak to peak [mm]", "lowest force [N]", "highest force [N]", "duration [s]",
    ]  # fmt: skip
    rows = [["0 V", 0.0, 20.0, -0.5, 0.5, 4.0], ["1.98 V", 1.98, 40.0, -1.0, 1.0, 2.0]]
    for row, expected in zip(table.rows, rows, strict=True):
        assert row[0] == expected[0]
        assert list(row[1:]) == pytest.approx(expected[1:], rel=1e-3)


def test_the_records_are_counted_and_their_durations_added(campaign: RecordedCampaign) -> None:
    description = description_of(campaign)
    assert description.rows == [("records", "2 records"), ("duration", "6 s")]
    assert description.data is not None
    assert description.data()["records"] == ["0 V", "1.98 V"]
