"""On-off groundhook: its decision, by its formula worked out by hand."""

import pytest

from dampyr.structures.control import groundhook

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("lower_velocity", "rate", "expected"),
    [(1, 2, HIGH), (-1, -2, HIGH), (1, -2, LOW), (-1, 2, LOW), (0, 2, LOW), (1, 0, LOW)],
)
def test_groundhook(lower_velocity, rate, expected):
    assert groundhook.decide(lower_velocity, rate, LOW, HIGH) == expected
