"""Sliding mode: on its surface the motion is that of much optimal control, and the wanted force leads there."""

import numpy as np
import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.structures import two_storey
from dampyr.structures.control import sliding_mode
from dampyr.structures.propagator import system

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("surface", "keeping", "force", "expected"),
    [
        (1.0, 0.0, -10.0, HIGH),
        (1.0, 0.0, -30.0, LOW),
        (-1.0, 0.0, 10.0, HIGH),
        (0.0, 15.0, 10.0, HIGH),
        (1.0, 0.0, 5.0, LOW),
    ],
)
def test_sliding_mode(surface, keeping, force, expected):
    assert sliding_mode.decide(surface, keeping, force, LOW, HIGH, 20.0, 0.0) == expected


def test_a_switching_force_adds_to_what_is_wanted():
    assert sliding_mode.decide(0.1, 0.0, -10.0, LOW, HIGH, 20.0, 0.0) == LOW
    assert sliding_mode.decide(0.1, 0.0, -10.0, LOW, HIGH, 20.0, 30.0) == HIGH


def test_the_wanted_force_makes_the_distance_to_the_surface_decay():
    building, reach = two_storey(), 7.0
    surface, keeping = (sensed("sliding_mode", argument=name, reach=reach)[:4] for name in ("surface", "keeping"))
    a, _, b = system(building, building.connection(1)[None])
    assert surface @ b[:, 0] == pytest.approx(1.0)
    closed = a + b @ (keeping - reach * surface)[None]
    assert surface @ closed == pytest.approx(-reach * surface, rel=1e-6, abs=1e-6 * np.abs(surface @ a).max())
