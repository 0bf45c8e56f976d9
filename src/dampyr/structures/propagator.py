r"""The exact propagator of a linear building over half a step and a whole step.

.. math:: \dot z = A z + E\,a_g + \sum_d B_d f_d, \qquad z = (q, \dot q)

The ground acceleration is linear over the step, each damper force is the quadratic through its values at 0,
h/2 and h. Under such inputs the solution is exact, whatever the step: the matrix exponential of the system
augmented by the derivatives of its input (Van Loan 1978). Time is counted in steps inside, so that the
exponentials are well scaled.

Reference: C. F. Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. Autom. Control
23 (1978).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.structures.building import Building

Array = NDArray[np.float64]

# the polynomials through the nodes: value, slope and curvature at the start, in units of the step
_QUADRATIC = np.array([[1.0, 0.0, 0.0], [-3.0, 4.0, -1.0], [4.0, -8.0, 4.0]])
_LINEAR = np.array([[1.0, 0.0], [-1.0, 1.0], [0.0, 0.0]])


@dataclass(frozen=True)
class Propagator:
    """One step of a building with N damper sites and n degrees of freedom.

    ``half`` and ``whole`` map ``(z0, ag0, ag1, f0, fh, f1)``, length ``2n + 2 + 3N``, to the state at h/2
    and h. ``explicit`` maps ``(z0, ag0, ag1, f0)`` and ``unknown`` maps ``(fh, f1)`` to the motion of the
    sites, ``(xh, vh, ah, x1, v1, a1)``, N values each: displacement, velocity, relative acceleration at h/2
    and h.
    """

    half: Array
    whole: Array
    explicit: Array
    unknown: Array


def propagator(building: Building, connections: Array, step: float) -> Propagator:
    """The propagator of ``building`` for dampers with the rows of ``connections`` (N, n), over
    ``step`` seconds."""
    n, sites = building.n, len(connections)
    half, whole = (transition(building, connections, step, part) for part in (0.5, 1.0))
    rows = _site_motion(building, connections, half, 0.5), _site_motion(building, connections, whole, 1.0)
    motion = np.vstack(rows)
    split = 2 * n + 2 + sites
    return Propagator(half, whole, np.ascontiguousarray(motion[:, :split]), np.ascontiguousarray(motion[:, split:]))


def system(building: Building, connections: Array) -> tuple[Array, Array, Array]:
    """``A`` (2n, 2n), ``E`` (2n,) and ``B`` (2n, N) of the equation above; a damper force opposes its
    own stroke."""
    n = building.n
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:] = np.eye(n)
    a[n:] = -np.linalg.solve(building.M, np.hstack([building.K, building.C]))
    e = np.concatenate([np.zeros(n), -building.influence])
    b = np.zeros((2 * n, len(connections)))
    b[n:] = -np.linalg.solve(building.M, connections.T)
    return a, e, b


def transition(building: Building, connections: Array, step: float, part: float) -> Array:
    """The state at ``part`` of a step from ``(z0, ag0, ag1, f0, fh, f1)``: (2n, 2n + 2 + 3N)."""
    from scipy.linalg import expm

    a, e, b = system(building, connections)
    inputs = np.column_stack([e, b])
    size, count = len(a), inputs.shape[1]
    big = np.zeros((size + 3 * count, size + 3 * count))
    big[:size, :size] = a * step
    big[:size, size : size + count] = inputs * step
    big[size : size + 2 * count, size + count :] = np.eye(2 * count)
    top = expm(big * part)[:size]
    by_derivative = top[:, size:].reshape(size, 3, count)
    ground = by_derivative[:, :, 0] @ _LINEAR
    forces = np.einsum("zdi,dk->zki", by_derivative[:, :, 1:], _QUADRATIC).reshape(size, -1)
    return np.ascontiguousarray(np.hstack([top[:, :size], ground, forces]))


def driven(building: Building, push: Array, step: float, part: float) -> Array:
    """The state at ``part`` of a step, from rest, under inputs that are linear over it: (2n, 2r) from the r values at its start
    and those at its end. ``push`` (n, r) is the acceleration of the coordinates by one unit of each."""
    from scipy.linalg import expm

    n, count = push.shape
    a = system(building, np.zeros((0, n)))[0]
    big = np.zeros((2 * n + 2 * count, 2 * n + 2 * count))
    big[: 2 * n, : 2 * n] = a * step
    big[n : 2 * n, 2 * n : 2 * n + count] = push * step
    big[2 * n : 2 * n + count, 2 * n + count :] = np.eye(count)
    top = expm(big * part)[: 2 * n, 2 * n :]
    by_value, by_slope = top[:, :count], top[:, count:]
    return np.ascontiguousarray(np.hstack([by_value - by_slope, by_slope]))


def driven_sites(building: Building, connections: Array, push: Array, step: float) -> tuple[Array, Array, Array]:
    """`driven` at h/2 and at h, and the motion of the sites under the same inputs (6N, 2r), as ``explicit`` has it."""
    n = building.n
    a = system(building, np.zeros((0, n)))[0]
    states, rows = [], []
    for part in (0.5, 1.0):
        state = driven(building, push, step, part)
        acceleration = a[n:] @ state + np.hstack([(1.0 - part) * push, part * push])
        states.append(state)
        rows += [connections @ state[:n], connections @ state[n:], connections @ acceleration]
    return states[0], states[1], np.ascontiguousarray(np.vstack(rows))


def _site_motion(building: Building, connections: Array, transition: Array, part: float) -> Array:
    """Displacement, velocity and acceleration of the sites, rows over all the inputs of a transition."""
    n, sites = building.n, len(connections)
    a, e, b = system(building, connections)
    acceleration = a[n:] @ transition
    acceleration[:, 2 * n : 2 * n + 2] += np.outer(e[n:], [1 - part, part])
    node = 2 if part == 1.0 else 1
    first = 2 * n + 2 + node * sites
    acceleration[:, first : first + sites] += b[n:]
    return np.vstack([connections @ transition[:n], connections @ transition[n:], connections @ acceleration])
