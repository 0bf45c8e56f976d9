"""The state space of chapter 5: its signs, by the equation of motion."""

import numpy as np
import pytest
from scipy import signal

import dampyr as dp
from dampyr.errors import InputError
from dampyr.structures import Building, from_state_space, respond, state_space, two_storey


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


def test_its_matrices_are_those_of_a_linear_system():
    """By scipy's lsim: floor accelerations of a building whose damper is a dashpot, fed back, are those of a response."""
    building, motion, c = two_storey(), dp.ground_motions.el_centro(), 800.0
    A, B, C, D = state_space(building, 1).matrices()
    feedback = c * building.connection(1) @ np.eye(4)[2:]  # the force of the dashpot from the states
    closed = signal.StateSpace(A + np.outer(B[:, 1], feedback), B[:, :1], C + np.outer(D[:, 1], feedback), D[:, :1])
    time = np.arange(0.0, 8.0, 0.0005)
    ground = np.interp(time, motion.time, motion.acceleration)
    _, accelerations, _ = signal.lsim(closed, ground, time)
    row = building.connection(1)
    damped = Building(building.M, building.C + c * np.outer(row, row), building.K)
    first = dp.ground_motions.GroundMotion(np.asarray(motion.acceleration)[: int(8.0 / motion.dt)], motion.dt, "8 s")
    expected = respond(damped, first).peak_acceleration
    assert np.abs(accelerations).max(axis=0) == pytest.approx(expected, rel=2e-3)


def test_it_names_inputs_outputs_and_states():
    model = state_space(two_storey(), [1, 2])
    assert model.labels == {
        "inputs": ["ground_acceleration", "force_1", "force_2"],
        "outputs": ["acceleration_1", "acceleration_2"],
        "states": ["displacement_1", "displacement_2", "velocity_1", "velocity_2"],
    }
    assert [matrix.shape for matrix in model.matrices()] == [(4, 4), (4, 3), (2, 4), (2, 3)]


def test_a_building_comes_back_from_its_state_space(building):
    for system in (state_space(building), signal.StateSpace(*state_space(building).matrices())):
        again = from_state_space(system, building.M, "again")
        assert pytest.approx(building.K, rel=1e-9, abs=1e-9 * np.abs(building.K).max()) == again.K
        assert pytest.approx(building.C, rel=1e-9, abs=1e-9 * np.abs(building.C).max()) == again.C
        assert again.frequencies == pytest.approx(building.frequencies)


@pytest.mark.by_hand  # python-control is no package of the tests
def test_python_control_takes_it_and_gives_it_back():
    control = pytest.importorskip("control")
    model = state_space(two_storey(), 1)
    system = control.ss(*model.matrices(), **model.labels)
    assert system.input_labels == model.labels["inputs"]
    assert from_state_space(system, two_storey().M).frequencies == pytest.approx(two_storey().frequencies)
    assert sorted(np.abs(system.poles()) / 2 / np.pi)[::2] == pytest.approx(two_storey().frequencies)


@pytest.mark.parametrize(
    ("system", "mass", "words"),
    [
        (np.eye(3), [1.0], "must be square and finite, with a displacement and a velocity for each floor"),
        (np.eye(4), [1.0, 1.0], "not displacements and then velocities"),
        (state_space(two_storey()), [1.0, 1.0, 1.0], r"give \(2,\) or \(2, 2\), as A is of 2 floors"),
        (state_space(two_storey()), [1.0, 9.0], "is not symmetric with this mass"),
    ],
)
def test_what_is_no_building_is_refused(system, mass, words):
    with pytest.raises(InputError, match=words):
        from_state_space(system, mass)
