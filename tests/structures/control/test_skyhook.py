"""Continuous skyhook: its decision, and what it senses."""

import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.structures.control import skyhook

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("signal", "rate", "ratio", "expected"),
    [(1, 2, 1, 1.75), (-1, -2, 1, 1.75), (1, 2, 0.5, 1.125), (3, 1, 1, HIGH), (1, -1, 1, LOW), (1, 0, 1, LOW)],
)
def test_skyhook_goes_with_the_ratio_of_the_velocities(signal, rate, ratio, expected):
    assert skyhook.decide(signal, rate, LOW, HIGH, ratio) == expected


@pytest.mark.parametrize("name", ["on_off", "skyhook"])
@pytest.mark.parametrize(
    ("place", "expected"),
    [(1, [0, 0, 1, 0, 1]), (2, [0, 0, 0, 1, 1]), ((0, 2), [0, 0, 0, 1, 1]), ((2, 0), [0, 0, 0, -1, -1])],
)
def test_skyhooks_sense_the_absolute_velocity_of_the_upper_floor(name, place, expected):
    assert sensed(name, place).tolist() == expected
