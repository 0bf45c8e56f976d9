"""Clipped-optimal: its decision, and its gains by a closed form."""

import numpy as np
import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.structures import single_mass
from dampyr.structures.control import clipped_optimal

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("wanted", "force", "expected"),
    [(9, 5, HIGH), (-9, -5, HIGH), (5, 9, LOW), (-5, -9, LOW), (-5, 9, LOW), (5, -9, LOW), (5, 0, LOW)],
)
def test_clipped_optimal_wants_more_of_the_same_force(wanted, force, expected):
    assert clipped_optimal.decide(wanted, force, LOW, HIGH) == expected


def test_the_optimal_gains_of_one_mass_are_those_of_the_closed_form():
    """Without damping the Riccati equation of one mass is two quadratics, one after the other."""
    m, k, effort = 300.0, 2e5, 0.07
    building = single_mass(m, stiffness=k)
    r, b2, w2 = effort / k, m**-2, k / m
    p12 = (-w2 + np.sqrt(w2**2 + k * b2 / r)) * r / b2
    p22 = np.sqrt((2 * p12 + m) * r / b2)
    expected = [p12 / (m * r), p22 / (m * r), 0.0]
    assert sensed("clipped_optimal", building=building, effort=effort) == pytest.approx(expected, rel=1e-9)


def test_less_effort_asks_for_more_force():
    soft, hard = (sensed("clipped_optimal", effort=effort) for effort in (1.0, 0.01))
    assert np.linalg.norm(hard) > 3 * np.linalg.norm(soft)
