"""What several laws design by: weights of the state, the gains of linear optimal control, the filter that estimates the
state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.structures.building import Building
from dampyr.structures.propagator import system

Array = NDArray[np.float64]


def weighted(building: Building, weights: Sequence[float]) -> Array:
    """Q (2n, 2n): of the diagonal ``weights`` of the floors, or diag(K, M) where there are none."""
    n = building.n
    if not len(weights):
        energy = np.zeros((2 * n, 2 * n))
        energy[:n, :n], energy[n:, n:] = building.K, building.M
        return energy
    given, floors = np.asarray(weights, dtype=float), building.n_floors
    if given.shape != (2 * floors,) or not np.all(np.isfinite(given)) or given.min() < 0 or given.max() == 0:
        raise InputError(
            f"weights = {tuple(weights)} is not allowed for {building.name}; give {2 * floors} numbers of at least 0, "
            "displacements first, not all 0"
        )
    rest = np.zeros(n - floors)  # of coordinates that are no floors
    return np.diag(np.concatenate([given[:floors], rest, given[floors:], rest]))


def stiffness_between(building: Building, row: Array) -> float:
    """The stiffness of the building between the damper's ends [N/m]."""
    if np.linalg.cond(building.K) > 1e12:
        raise InputError(f"{building.name} can move without springs, so this law has no stiffness to go by")
    return 1.0 / float(row @ np.linalg.solve(building.K, row))


def optimal_gains(building: Building, row: Array, effort: float, weights: Sequence[float]) -> Array:
    r"""G (2n,) of the wanted force :math:`-G z` that makes :math:`\int (z^T Q z + R f^2)\,dt` least, R being ``effort`` over
    the
    stiffness between the damper's ends."""
    from scipy.linalg import solve_continuous_are

    a, _, b = system(building, row[None])
    cost = effort / stiffness_between(building, row)
    p = solve_continuous_are(a, b, weighted(building, weights), np.array([[cost]]))
    return np.asarray((b.T @ p)[0] / cost)


def held_steps(building: Building, row: Array, period: float) -> tuple[Array, Array, Array]:
    """Phi (2n, 2n), Gamma (2n,) and Gamma_g (2n,) of the state over a period in which the damper's force and the ground's
    acceleration are held."""
    from scipy.linalg import expm

    a, e, b = system(building, row[None])
    n = building.n
    held = np.zeros((2 * n + 2, 2 * n + 2))
    held[: 2 * n] = np.column_stack([a, b, e])
    step = expm(held * period)[: 2 * n]
    return step[:, : 2 * n], step[:, 2 * n], step[:, 2 * n + 1]


def state_filter(
    building: Building, row: Array, period: float, noise: float, disturbance: float
) -> tuple[Array, Array, Array]:
    r"""The steady Kalman filter of the state from all floors' absolute accelerations and the damper's force: (estimate, F, G).

    ``estimate`` (2n, 2n + Y) makes :math:`\hat z` of the memory and the measures, ``F`` and ``G`` the next memory. ``noise`` is
    the standard deviation of an accelerometer, ``disturbance`` that of the ground's acceleration, held over the ``period``.
    """
    from scipy.linalg import solve_discrete_are

    a, _, b = system(building, row[None])
    n, floors = building.n, building.n_floors
    phi, gamma, push = held_steps(building, row, period)
    C, D = a[n : n + floors], b[n : n + floors]
    P = solve_discrete_are(phi.T, C.T, disturbance**2 * np.outer(push, push), noise**2 * np.eye(floors))
    L = P @ C.T @ np.linalg.inv(C @ P @ C.T + noise**2 * np.eye(floors))
    estimate = np.hstack([np.eye(2 * n) - L @ C, L, -L @ D])
    F, G = phi @ estimate[:, : 2 * n], phi @ estimate[:, 2 * n :]
    G[:, floors] += gamma
    return estimate, F, G
