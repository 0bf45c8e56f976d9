"""The state space of chapter 5: its signs, by the equation of motion."""

import numpy as np
import pytest

from dampyr.structures import state_space, two_storey


def test_state_space_has_the_sign_that_the_equation_of_motion_asks_for():
    building = two_storey()
    model = state_space(building, 1)
    assert model.connection.ravel().tolist() == [-1.0, 0.0]
    rng = np.random.default_rng(5)
    x, f, ground = rng.normal(size=4), rng.normal(size=1), rng.normal()
    relative = np.linalg.solve(
        building.M,
        -building.M @ [1, 1] * ground + model.connection @ f - building.C @ x[2:] - building.K @ x[:2],
    )
    assert (model.A @ x + model.B @ f + model.E * ground)[2:] == pytest.approx(relative)
    assert model.C @ x + model.D @ f == pytest.approx(relative + ground)
    assert np.array_equal(model.D, model.B[2:])  # (5.6) prints the other sign


def test_state_space_of_two_dampers():
    model = state_space(two_storey(), [1, 2])
    assert model.connection.tolist() == [[-1.0, 1.0], [0.0, -1.0]]
    assert model.B.shape == (4, 2)


def test_state_space_takes_places(building):
    model = state_space(building, [1, (0, 3)])
    assert model.connection.tolist() == [[-1.0, 0.0], [0.0, 0.0], [0.0, -1.0]]
