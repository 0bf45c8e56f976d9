r"""The building's step in the coordinates in which a kernel takes it, and what is looked at on the way.

.. math:: \zeta_1 = \Phi \zeta_0 + g_0 a_0 + g_1 a_1 + P_0 f_0 + P_h f_h + P_1 f_1

with the ground's acceleration linear and the dampers' forces quadratic over the step (see
`dampyr.structures.propagator`). Up to two degrees of freedom the state is displacements and velocities; beyond,
it is that of the building's modes, so that
:math:`\Phi` has blocks of two and the cost grows with the number of modes and not with its square: amplitude and rate of each
mode where the damping is classical, and otherwise the complex modes in real pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.structures.building import Building
from dampyr.structures.propagator import system, transition

Array = NDArray[np.float64]
DENSE_UP_TO = 2  # degrees of freedom
COUPLED = 1e-12  # of the largest entry of the modal damping: what rounding leaves beside the diagonal
WORST_CONDITION = 1e6  # of the modes; beyond it two of them are nearly one, and the dense form is used


@dataclass(frozen=True, eq=False)
class ModalStep:
    """One step of a building with N sites, in D coordinates.

    ``end`` (D, D + 2 + 3N) takes (state, a0, a1, f0, fh, f1) to the state after ``h`` seconds; ``sites`` (2N, D) takes a
    state to strokes and rates; ``displacement``, ``drift`` (floors, D) and ``acceleration`` (floors, D + N + 1) look at a state
    (and the forces, and the ground's acceleration).
    """

    h: float
    end: Array
    sites: Array
    displacement: Array
    drift: Array
    acceleration: Array
    is_stack: bool = True  # whether a drift is the displacement of a floor less that of the floor before it


def step(building: Building, connections: Array, h: float, basis: Array | None = None) -> ModalStep:
    """The step of ``h`` seconds in ``basis`` (2n, 2n): columns are the coordinates' shapes (default: the physical ones)."""
    n = building.n
    T = np.eye(2 * n) if basis is None else basis
    inverse = np.linalg.inv(T)
    a, _, b = system(building, connections)
    whole = transition(building, connections, h, 1.0)
    both = np.kron(np.eye(2), connections)
    end = np.hstack([inverse @ whole[:, : 2 * n] @ T, inverse @ whole[:, 2 * n :]])
    floors = building.n_floors
    drift = np.array([building.connection(storey) for storey in range(1, floors + 1)])
    look = np.hstack([a[n:] @ T, b[n:], building.ground_terms()[0][:, None]])
    return ModalStep(
        h, _clean(end, basis), both @ T, T[:floors].copy(), drift @ T[:n], look[:floors], building.is_stack
    )


def _clean(end: Array, basis: Array | None) -> Array:
    """Blocks of two on the diagonal: what rounding leaves beside them is nothing."""
    if basis is not None:
        size = len(end)
        off_block = np.kron(np.eye(size // 2), np.ones((2, 2))) == 0
        end[:, :size][off_block] = 0.0
    return end


def classical_modes(building: Building) -> Array | None:
    """Displacement and velocity of each undamped mode in turn (2n, 2n), or None where the damping couples modes."""
    n, (_, shapes) = building.n, building.modes()
    damping = shapes.T @ building.C @ shapes
    if np.max(np.abs(damping - np.diag(np.diag(damping)))) > COUPLED * np.max(np.abs(damping), initial=0.0):
        return None
    basis = np.zeros((2 * n, 2 * n))
    basis[:n, 0::2] = basis[n:, 1::2] = shapes
    return basis


def complex_modes(building: Building) -> Array | None:
    """A real basis (2n, 2n) of the complex modes in pairs, or None where it would be too ill-conditioned."""
    a, _, _ = system(building, np.zeros((0, building.n)))
    values, vectors = np.linalg.eig(a)
    order = np.lexsort((values.imag, values.real, np.abs(values)))
    complex_, real = [k for k in order if values[k].imag > 0], [k for k in order if values[k].imag == 0]
    columns = [part for k in complex_ for part in (vectors[:, k].real, vectors[:, k].imag)]
    columns += [vectors[:, k].real for k in real]
    basis = np.column_stack(columns)
    basis /= np.linalg.norm(basis, axis=0)
    return basis if np.linalg.cond(basis / _sizes(building)[:, None]) < WORST_CONDITION else None


def _sizes(building: Building) -> Array:
    """What a displacement and a velocity are measured in, so that one does not drown the other."""
    rate = float(np.sqrt(np.trace(building.K) / np.trace(building.M)))
    return np.repeat([1.0, max(rate, 1e-9)], building.n)


def basis_of(building: Building) -> Array | None:
    """The basis that the kernels use: None for the physical one."""
    if building.n <= DENSE_UP_TO:
        return None
    classical = classical_modes(building)
    return complex_modes(building) if classical is None else classical
