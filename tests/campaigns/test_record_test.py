"""What a record of a campaign says of itself: its session and its specimen."""

from dataclasses import replace
from datetime import datetime
from pathlib import Path

import pytest
from tests.campaigns.quick_rig import TWO, quick_rig

from dampyr import campaigns
from dampyr.campaigns import perform
from dampyr.campaigns.record_test import groups_of
from dampyr.rig import RigSettings


def test_a_record_says_its_session_and_its_specimen(two: Path, tmp_path: Path) -> None:
    """Where nothing is said: the day of the run, and the data sheet; what is said goes before it."""
    days = {datetime.now().astimezone().date().isoformat()}
    first, second = perform(two, quick_rig(), tmp_path / "a")
    days.add(datetime.now().astimezone().date().isoformat())  # the run may have begun before midnight
    assert first.specimen == second.specimen == "RD-8041-1"
    assert first.measurement_session == second.measurement_session
    assert first.measurement_session in {f"{day} RD-8041-1" for day in days}
    two.write_text('measurement_session = " third mounting "\nspecimen = "no. 7"\n' + TWO, encoding="utf-8")
    for record in perform(two, quick_rig(), tmp_path / "b"):
        assert (record.measurement_session, record.specimen) == ("third mounting", "no. 7")


@pytest.mark.parametrize(
    ("specimen", "stated", "expected"),
    [
        ({}, {}, ("2026-03-01 RD-8041-1", "RD-8041-1")),
        ({"card": "cards/number_7.toml"}, {}, ("2026-03-01 number_7", "number_7")),
        ({"card": "number_7.toml", "name": "no. 7"}, {}, ("2026-03-01 no. 7", "no. 7")),
        ({"name": "no. 7"}, {"specimen": "no. 8"}, ("2026-03-01 no. 8", "no. 8")),
        ({"data_sheet": ""}, {}, ("2026-03-01", None)),
        ({"name": "no. 7"}, {"measurement_session": "day 1"}, ("day 1", "no. 7")),
    ],
)
def test_what_the_campaign_states_goes_before_what_the_rig_does(
    two: Path, specimen: dict[str, str], stated: dict[str, str], expected: tuple[str, str | None]
) -> None:
    settings = replace(RigSettings(), specimen=replace(RigSettings().specimen, **specimen))
    campaign = campaigns.read(two)
    campaign = replace(campaign, header=replace(campaign.header, **stated))
    groups = groups_of(settings, campaign, datetime(2026, 3, 1, 23, 59).astimezone())
    assert (groups["measurement_session"], groups.get("specimen")) == expected
