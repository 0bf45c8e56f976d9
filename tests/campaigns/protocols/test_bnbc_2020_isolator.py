"""BNBC 2020 section 2.5.16.4: the sequence for isolators, as read in the text of the code."""

import pytest

from dampyr import campaigns
from dampyr.errors import InputError

TABLE = {
    "kind": "bnbc_2020_isolator",
    "wind_displacement": "1 mm",
    "design_displacement": "8 mm",
    "maximum_displacement": "10 mm",
    "total_design_displacement": "9 mm",
    "total_maximum_displacement": "12 mm",
    "frequency": "0.5 Hz",
}


def test_the_levels_and_cycles_are_those_of_the_code():
    tests = campaigns.campaign_of({"protocol": TABLE}).tests
    levels = [(round(1e3 * test.step.amplitude, 6), test.step.cycles) for test in tests]
    assert levels == [(1, 20), (2, 3), (4, 3), (8, 3), (10, 3), (12, 3), (9, 10)]


def test_a_maximum_below_the_design_displacement_is_refused():
    with pytest.raises(InputError, match=r"design_displacement = 8 mm is more than maximum_displacement = 7 mm"):
        campaigns.campaign_of({"protocol": TABLE | {"maximum_displacement": "7 mm"}})
