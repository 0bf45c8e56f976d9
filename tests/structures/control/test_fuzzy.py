"""Fuzzy control: its table at the corners and between them, and an on-off law in the limit."""

import pytest

from dampyr.structures.control import fuzzy, on_off

LOW, HIGH = 0.5, 3.0
RULES = {"same": 0.9, "opposite": 0.2, "floor": 0.6, "damper": 0.3, "still": 0.1}


def input_of(a, b, rules):
    return fuzzy.decide(a * 0.2, b * 0.2, LOW, HIGH, 0.2, **rules)


def by_memberships(a, b, rules):
    """The sum over the nine rules, by triangles written out here."""
    centres = (-1.0, 0.0, 1.0)
    total = 0.0
    for ca in centres:
        for cb in centres:
            weight = 1.0
            for value, centre in ((max(-1.0, min(1.0, a)), ca), (max(-1.0, min(1.0, b)), cb)):
                weight *= max(0.0, 1.0 - abs(value - centre))
            rule = "still" if ca == cb == 0 else "damper" if ca == 0 else "floor" if cb == 0 else ""
            total += weight * rules[rule or ("same" if ca == cb else "opposite")]
    return LOW + (HIGH - LOW) * total


@pytest.mark.parametrize("a", [-2.0, -1.0, -0.3, 0.0, 0.7, 1.0])
@pytest.mark.parametrize("b", [-1.5, -0.6, 0.0, 0.2, 1.0])
def test_fuzzy(a, b):
    assert input_of(a, b, RULES) == pytest.approx(by_memberships(a, b, RULES))


def test_far_beyond_its_speed_the_default_is_on_off():
    rules = {"same": 1.0, "opposite": 0.0, "floor": 0.5, "damper": 0.0, "still": 0.0}
    for a, b in ((5.0, 3.0), (-5.0, 3.0), (-2.0, -2.0)):
        assert input_of(a, b, rules) == on_off.decide(a, b, LOW, HIGH)
