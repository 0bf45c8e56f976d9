"""On-off skyhook: its decision, by its equation written out here."""

import pytest

from dampyr.structures.control import on_off

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("signal", "rate", "expected"), [(1, 1, HIGH), (-1, -1, HIGH), (1, -1, LOW), (-1, 1, LOW), (0, 1, LOW), (1, 0, LOW)]
)
def test_on_off(signal, rate, expected):
    assert on_off.decide(signal, rate, LOW, HIGH) == expected
