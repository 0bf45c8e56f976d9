"""Power-driven: its damping by its formula written out here, and what it works out of a building."""

import numpy as np
import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.errors import InputError
from dampyr.structures import control_law, single_mass
from dampyr.structures.control import power_driven

LOW, HIGH, K, CRITICAL, LEAST, GREATEST = 0.5, 3.0, 2e4, 1500.0, 0.1, 0.6


def by_the_source(x, v):
    c_min, c_max = LEAST * CRITICAL, GREATEST * CRITICAL
    if K * x * v + c_min * v * v >= 0:
        c = c_min
    elif K * x * v + c_max * v * v < 0:
        c = c_max
    else:
        c = -K * x / v
    return LOW + (HIGH - LOW) * (c - c_min) / (c_max - c_min)


@pytest.mark.parametrize("v", [-0.5, -0.01, 0.02, 0.3])
@pytest.mark.parametrize("x", [-0.02, -0.001, 0.0, 0.004, 0.05])
def test_power_driven(x, v):
    given = power_driven.decide(K * x / CRITICAL, v, LOW, HIGH, LEAST, GREATEST)
    assert given == pytest.approx(by_the_source(x, v))
    assert LOW <= given <= HIGH


def test_the_critical_damping_is_that_of_the_mass_that_moves():
    m, k = 300.0, 2e5
    row = sensed("power_driven", building=single_mass(m, stiffness=k), argument="spring")
    assert row == pytest.approx([k / (2 * np.sqrt(k * m)), 0.0, 0.0])


def test_shares_the_wrong_way_round_are_refused():
    with pytest.raises(InputError, match=r"least = 0.7 of power_driven is not below greatest = 0.5"):
        control_law("power_driven", high=1.0, least=0.7)
