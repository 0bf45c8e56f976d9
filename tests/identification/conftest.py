"""The published campaign and its joint fit, read and fitted once for all files that look at them."""

from pathlib import Path

import pytest

from dampyr.identification import Fit, fit
from dampyr.records import Record, read_campaign


@pytest.fixture(scope="session")
def published_records(campaign_folder: Path) -> list[Record]:
    """All records of the published campaign, those for validation too."""
    return read_campaign(campaign_folder, role=None)


@pytest.fixture(scope="session")
def published_fit_records(published_records: list[Record]) -> list[Record]:
    """Those that are fitted."""
    return [record for record in published_records if record.role == "fit"]


@pytest.fixture(scope="session")
def published_fit(published_fit_records: list[Record]) -> Fit:
    """The plain Dahl model on all of them together."""
    return fit(published_fit_records, "dahl")
