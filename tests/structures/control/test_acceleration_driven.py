"""Acceleration-driven: its decision, by its formula worked out by hand."""

import pytest

from dampyr.structures.control import acceleration_driven

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("acceleration", "rate", "expected"),
    [(1, 2, HIGH), (-1, -2, HIGH), (1, -2, LOW), (-1, 2, LOW), (0, 2, LOW), (1, 0, LOW)],
)
def test_acceleration_driven(acceleration, rate, expected):
    assert acceleration_driven.decide(acceleration, rate, LOW, HIGH) == expected
