"""Clipped-optimal with an observer: its decision, and how near its estimate comes to the state."""

import numpy as np
import pytest

from dampyr.ground_motions import kanai_tajimi
from dampyr.structures import control_law, respond, two_storey
from dampyr.structures.control import clipped_optimal_lqg
from dampyr.structures.controller import ControllerRun, design_controller
from dampyr.structures.sensors import MEASURES, DamperPlace
from dampyr.studies import raminelli_2020

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(("wanted", "force", "expected"), [(9, 5, HIGH), (-9, -5, HIGH), (5, 9, LOW), (-5, 9, LOW)])
def test_it_wants_more_of_the_same_force(wanted, force, expected):
    assert clipped_optimal_lqg.decide(wanted, force, LOW, HIGH) == expected


def test_its_estimate_follows_the_state_of_a_response():
    """Fed with the accelerations and the force of a response at constant input, it wants what the whole state would, to 6 %."""
    building, motion = two_storey(), kanai_tajimi(4.0, 0.001, seed=3, pga=2.0)
    response = respond(building, motion, {1: raminelli_2020.damper()}, voltage=1.0)
    row = building.connection(1)[None]
    made = design_controller(control_law("clipped_optimal_lqg", high=HIGH, period=0.001, noise=1e-3), building, row, 0)
    known = design_controller(control_law("clipped_optimal", high=HIGH), building, row, 0)
    run, estimated, true = ControllerRun(made), [], []
    for k in range(motion.n):
        w = np.concatenate([response.displacement[:, k], response.velocity[:, k], [0.0, 0.0], response.force[:, k]])
        y = run.measured(w)
        estimated.append(float((made.of_memory @ run.memory + made.of_measured @ y)[0]))
        true.append(float((known.of_measured @ known.rows @ w)[0]))
        run.memory = made.F @ run.memory + made.G @ y
    assert MEASURES["accelerations"].rows(DamperPlace(building, row, 0)).shape == (2, 7)
    error = np.array(estimated) - true
    assert np.sqrt(np.mean(error**2)) < 0.06 * np.sqrt(np.mean(np.square(true)))
