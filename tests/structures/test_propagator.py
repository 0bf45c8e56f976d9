"""The exact step of a linear building, against scipy's integration of its equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dampyr.structures import two_storey
from dampyr.structures.propagator import propagator, system, transition

STEP = 0.05  # s, a tenth of the first period: what is exact is so at any step
ROWS = np.array([[1.0, 0.0], [-1.0, 1.0]])  # a damper in each storey


def start() -> np.ndarray:
    """(z0, ag0, ag1, f0, fh, f1) of two floors with two dampers."""
    return np.random.default_rng(5).uniform(-1.0, 1.0, 12) * [*[0.01] * 2, *[0.2] * 2, 3.0, 3.0, *[400.0] * 6]


def test_the_system_is_newtons_law() -> None:
    building, state, ground, forces = two_storey(), start()[:4], 2.5, np.array([300.0, -120.0])
    a, e, b = system(building, ROWS)
    q, v = state[:2], state[2:]
    pull = building.K @ q + building.C @ v + ROWS.T @ forces + building.M @ np.ones(2) * ground
    np.testing.assert_allclose(
        a @ state + e * ground + b @ forces, [*v, *-np.linalg.solve(building.M, pull)], rtol=1e-12
    )


@pytest.mark.parametrize("part", [0.5, 1.0, 0.3])
def test_a_step_is_the_integral_of_the_equation(part: float) -> None:
    """The ground's acceleration is linear over the step, a damper's force the quadratic through its three values."""
    a, e, b = system(two_storey(), ROWS)
    u = start()
    early, middle, late = u[6:8], u[8:10], u[10:12]

    def rates(t: float, z: np.ndarray) -> np.ndarray:
        s = t / STEP
        force = early * (1 - s) * (1 - 2 * s) + 4 * middle * s * (1 - s) + late * s * (2 * s - 1)
        return a @ z + e * (u[4] + (u[5] - u[4]) * s) + b @ force

    done = solve_ivp(rates, (0.0, part * STEP), u[:4], "DOP853", rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(transition(two_storey(), ROWS, STEP, part) @ u, done.y[:, -1], rtol=1e-9, atol=1e-12)


def test_the_motion_of_the_sites_is_that_of_the_floors() -> None:
    """Stroke, rate and acceleration between the ends of each damper, at half a step and at its end."""
    one, u = propagator(two_storey(), ROWS, STEP), start()
    a, e, b = system(two_storey(), ROWS)
    motion = one.explicit @ u[:8] + one.unknown @ u[8:]
    expected = []
    for part, matrix, force in ((0.5, one.half, u[8:10]), (1.0, one.whole, u[10:12])):
        z = matrix @ u
        acceleration = (a @ z + e * (u[4] + part * (u[5] - u[4])) + b @ force)[2:]
        expected += [ROWS @ z[:2], ROWS @ z[2:], ROWS @ acceleration]
    np.testing.assert_allclose(motion, np.concatenate(expected), rtol=1e-9, atol=1e-12)
