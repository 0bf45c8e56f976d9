"""Passive-on: the greatest input."""

from dampyr.structures.control import passive_on


def test_passive_on():
    assert passive_on.decide(3.0) == 3.0
