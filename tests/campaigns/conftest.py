"""Campaigns that several files of tests look at, performed once; a test that changes a folder copies it."""

from pathlib import Path

import pytest
from tests.campaigns.quick_rig import SHORT, quick_rig

from dampyr.campaigns import perform


@pytest.fixture(scope="session")
def drifted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a campaign whose load cell drifts by 5 N/s."""
    folder = tmp_path_factory.mktemp("drifted")
    (folder / "short.toml").write_text(SHORT.format(voltage='["0 V", "1 V"]'))
    return perform(folder / "short.toml", quick_rig("drifting-cell=5@2s"), folder / "out").folder
