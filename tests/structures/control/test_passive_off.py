"""Passive-off: the least input."""

from dampyr.structures.control import passive_off


def test_passive_off():
    assert passive_off.decide(0.5) == 0.5
