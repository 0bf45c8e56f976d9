"""A fit that several descriptions and pages show."""

import pytest
from tests.show.fit_examples import records

from dampyr.identification import Fit, fit


@pytest.fixture(scope="session")
def joint() -> Fit:
    """The fit of six records at three voltages."""
    return fit(records(), "dahl")
