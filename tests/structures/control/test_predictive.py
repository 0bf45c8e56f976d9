"""Predictive control: its decision, and its force by trying forces in a simulation of the horizon."""

import numpy as np
import pytest
from scipy.signal import cont2discrete
from tests.structures.control.sensed_signals import sensed

from dampyr.errors import InputError
from dampyr.structures import two_storey
from dampyr.structures.control import predictive
from dampyr.structures.propagator import system

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("lowest", "force", "expected"),
    [(9, 5, HIGH), (-9, -5, HIGH), (5, 9, LOW), (-5, -9, LOW), (-5, 9, LOW), (5, -9, LOW), (5, 0, LOW)],
)
def test_predictive_wants_more_force_where_that_lowers_the_cost(lowest, force, expected):
    assert predictive.decide(lowest, force, LOW, HIGH) == expected


@pytest.mark.parametrize(("horizon", "ground"), [(0.005, 1.0), (0.1, 1.0), (0.1, 0.0), (0.35, 0.4)])
def test_its_force_is_the_cheapest_of_those_that_are_tried(horizon, ground):
    """The horizon step by step by scipy's discretisation, under three forces; a parabola through their costs."""
    building, effort, rng = two_storey(), 0.03, np.random.default_rng(4)
    row = building.connection(1)
    a, e, b = system(building, row[None])
    phi, push, *_ = cont2discrete((a, np.column_stack([b[:, 0], e]), np.eye(4), np.zeros((4, 2))), 0.005)
    Q = np.block([[building.K, np.zeros((2, 2))], [np.zeros((2, 2)), building.M]])
    R = effort * float(row @ np.linalg.solve(building.K, row))
    given = sensed("predictive", argument="lowest", horizon=horizon, ground=ground, effort=effort)
    whole = np.append(given[:4], of_ground(horizon, ground, effort))
    for _ in range(5):
        z0, ag = rng.standard_normal(4) * [1e-3, 1e-3, 0.05, 0.05], 2.0 * rng.standard_normal()
        forces, costs = np.array([-1e3, 0.0, 1e3]), []
        for f in forces:
            z, cost = z0, 0.0
            for _ in range(round(horizon / 0.005)):
                z = phi @ z + push @ [f, ground * ag]
                cost += z @ Q @ z + R * f * f
            costs.append(cost)
        square, line, _ = np.polyfit(forces, costs, 2)
        assert whole @ [*z0, ag] == pytest.approx(-line / (2.0 * square), rel=1e-6)


def of_ground(horizon, ground, effort):
    """The factor of the ground's acceleration."""
    from dampyr.structures import control_law
    from dampyr.structures.controller import design_controller

    law = control_law("predictive", high=HIGH, horizon=horizon, ground=ground, effort=effort)
    return design_controller(law, two_storey(), two_storey().connection(1)[None], 0).rows[0][5]


def test_a_horizon_that_is_no_period_is_refused():
    with pytest.raises(
        InputError, match=r"horizon = 0.002 s of predictive is 0.4 of its periods of 0.005 s; give 1 to"
    ):
        sensed("predictive", horizon=0.002)
