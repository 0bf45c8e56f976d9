"""The records of a campaign that was performed: a sequence that is read when it is used."""

from pathlib import Path

import numpy as np
import pytest
from tests.campaigns.quick_rig import FIRST, SECOND

from dampyr import records
from dampyr.campaigns.recorded_campaign import RecordedCampaign
from dampyr.errors import MissingData


def test_it_is_the_records_of_its_folder_in_their_order(two_sines: Path) -> None:
    campaign = RecordedCampaign(two_sines / "out")
    read = records.read_campaign(two_sines / "out")
    assert len(campaign) == 2
    assert [record.name for record in campaign] == [FIRST, SECOND]
    np.testing.assert_array_equal(campaign[1].force, read[1].force)
    assert [record.name for record in campaign[:1]] == [FIRST]
    assert campaign.records is campaign.records  # read once


def test_its_origin_and_findings_are_those_of_its_records(two_sines: Path, drifted: Path) -> None:
    campaign = RecordedCampaign(two_sines / "out")
    assert campaign.origin.sources == tuple(source for record in campaign for source in record.origin.sources)
    assert not [f for f in campaign.findings if "zero drifts" in f.words]
    [drifts] = [f for f in RecordedCampaign(drifted).findings if "zero drifts" in f.words]
    assert len(drifts.about) == 2


def test_nothing_is_read_before_it_is_used(tmp_path: Path) -> None:
    campaign = RecordedCampaign(tmp_path / "none")
    with pytest.raises(MissingData, match="none"):
        len(campaign)
