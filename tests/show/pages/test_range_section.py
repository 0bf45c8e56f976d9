"""The section on the range that a damper was calibrated on."""

import pytest

from dampyr.identification import Fit
from dampyr.show.pages.range_section import range_section, range_table


def test_the_calibrated_range_is_that_of_the_damper(joint: Fit) -> None:
    assert joint.damper is not None
    rows = {row[0]: row[1:4] for row in range_table(joint.damper).rows}
    assert rows["voltage"] == [0.0, 2.0, "V"]
    assert rows["displacement from the middle"][1:] == [pytest.approx(6.0, rel=0.02), "mm"]
    assert rows["frequency"] == [pytest.approx(1.1, rel=0.02), pytest.approx(1.3, rel=0.02), "Hz"]
    assert len(range_section(joint).blocks) == 2
