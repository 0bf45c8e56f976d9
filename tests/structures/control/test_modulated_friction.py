"""Modulated homogeneous friction: its memory of the latest turn, sample by sample, and its decision."""

import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.structures import single_mass
from dampyr.structures.control import modulated_friction

LOW, HIGH = 0.5, 3.0


def test_the_level_is_that_of_the_latest_turn():
    turned, before, levels = 0.0, 0.0, []
    for stroke, rate in ((0.0, 1.0), (1.0, 1.0), (2.0, -1.0), (1.0, -1.0), (-3.0, 1.0), (-2.0, 1.0)):
        turned, before = modulated_friction.update(stroke, rate, turned, before)
        levels.append(turned)
    assert levels == [0.0, 0.0, 2.0, 2.0, -3.0, -3.0]


@pytest.mark.parametrize(
    ("turned", "force", "expected"), [(2, 1, HIGH), (2, -1, HIGH), (-2, 1, HIGH), (2, 3, LOW), (0, 0, LOW)]
)
def test_the_force_is_held_at_the_level(turned, force, expected):
    assert modulated_friction.decide(turned, force, LOW, HIGH) == expected


def test_the_level_is_a_share_of_the_springs_force():
    row = sensed("modulated_friction", building=single_mass(300.0, stiffness=2e5), argument="level", ratio=0.3)
    assert row == pytest.approx([0.3 * 2e5, 0.0, 0.0])
