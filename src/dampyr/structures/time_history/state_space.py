r"""The state space of chapter 5.

.. math:: \dot X = A_s X + B_s f + E_s \ddot x_g, \qquad y = C_y X + D_y f + F_y \ddot x_g

X = (q, dq/dt), f the damper forces and y the absolute accelerations of the floors; :math:`F_y` is 0 but for a reduced
structure, of which the modes left out move with the ground. Equations (5.3) to (5.6)
of Raminelli (2020), with :math:`D_y = +M^{-1}\Lambda`: the minus sign that (5.6) prints contradicts (5.1)
and its own :math:`B_s`, since :math:`y = \ddot q + T \ddot x_g = M^{-1}(-K q - C \dot q + \Lambda f)`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.structures.propagator import system
from dampyr.structures.supports import refuse_supports

Array = NDArray[np.float64]
ASYMMETRY = 1e-6  # of the largest entry: more is no rounding


@dataclass(frozen=True, eq=False, repr=False)
class StateSpace(Shown):
    """``A`` (2n, 2n), ``B`` (2n, N), ``E`` (2n,), ``C`` (floors, 2n), ``D`` (floors, N), ``connection``
    Lambda (n, N), and ``F`` (floors,)."""

    A: Array
    B: Array
    E: Array
    C: Array
    D: Array
    connection: Array
    F: Array

    def matrices(self) -> tuple[Array, Array, Array, Array]:
        r"""A, B, C and D of :math:`\dot X = A X + B u`, :math:`y = C X + D u`, with u the acceleration of the ground [m/s2] and
        then the damper forces [N].

        These are what `scipy.signal.StateSpace` and, with `labels`, python-control's ``ss`` take:

        >>> import dampyr as dp, scipy.signal
        >>> model = dp.structures.state_space(dp.structures.two_storey(), 1)
        >>> scipy.signal.StateSpace(*model.matrices()).B.shape
        (4, 2)
        """
        return self.A, np.column_stack([self.E, self.B]), self.C, np.column_stack([self.F, self.D])

    @property
    def labels(self) -> dict[str, list[str]]:
        """Names of inputs, outputs and states for python-control, ``control.ss(*model.matrices(), **model.labels)``."""
        n, dampers = self.connection.shape
        return {
            "inputs": ["ground_acceleration", *(f"force_{k}" for k in range(1, dampers + 1))],
            "outputs": [f"acceleration_{k}" for k in range(1, len(self.C) + 1)],
            "states": [f"{what}_{k}" for what in ("displacement", "velocity") for k in range(1, n + 1)],
        }


def state_space(building: Building, storey: int | Sequence[Any] = 1) -> StateSpace:
    """Equations (5.3) to (5.6) for dampers in one storey or a list of places, each a storey or two floors.

    Lambda holds -1 on the floor above the damper and +1 on the one below: a force that opposes the growth
    of the drift is positive. A reduced structure is taken as it is given: with `refined` it has the coordinates that responses
    take, and n is their number.
    """
    refuse_supports("state_space", building)
    n = building.n
    places = storey if isinstance(storey, Sequence) else [storey]
    rows = np.array([building.connection(place) for place in places]).reshape(-1, n)
    a, e, b = system(building, rows)
    floors = slice(n, n + building.n_floors)
    return StateSpace(
        a, b, e, a[floors].copy(), b[floors].copy(), -rows.T, building.ground_terms()[0][: building.n_floors]
    )


def from_state_space(system: Any, mass: ArrayLike, name: str = "building") -> Building:
    r"""The building of a state space whose states are the displacements of the floors and then their velocities.

    With :math:`A = \begin{pmatrix} 0 & I \\ -M^{-1} K & -M^{-1} C \end{pmatrix}`, K and C follow from the masses, which A
    does not hold.

    Parameters
    ----------
    system
        the matrix A (2n, 2n), or what has one, such as a ``StateSpace`` of python-control or scipy.
    mass
        of the floors, kg, (n,), or the matrix M (n, n).
    name
        of the building.

    Raises
    ------
    InputError
        A is of another form, or M A is not symmetric, as where the masses belong to another building.

    Examples
    --------
    >>> import dampyr as dp
    >>> building = dp.structures.two_storey()
    >>> again = dp.structures.from_state_space(dp.structures.state_space(building), building.M)
    >>> bool(abs(again.K / building.K - 1.0).max() < 1e-12)
    True
    """
    A = np.asarray(getattr(system, "A", system), dtype=float)
    if A.ndim != 2 or A.shape[0] != A.shape[1] or len(A) % 2 or not len(A) or not np.all(np.isfinite(A)):
        raise InputError(
            f"A has the shape {A.shape}; it must be square and finite, with a displacement and a velocity for each floor"
        )
    n = len(A) // 2
    if np.any(A[:n, :n]) or not np.array_equal(A[:n, n:], np.eye(n)):
        raise InputError(
            "the upper half of A is not (0, I), so its states are not displacements and then velocities; transform the system "
            "to these, or give M, C and K to Building"
        )
    M = np.asarray(mass, dtype=float)
    M = np.diag(M) if M.ndim == 1 else M
    if M.shape != (n, n):
        raise InputError(f"the mass has the shape {M.shape}; give ({n},) or ({n}, {n}), as A is of {n} floors")
    symmetric = []
    for letter, product in (("K", -M @ A[n:, :n]), ("C", -M @ A[n:, n:])):
        if np.max(np.abs(product - product.T)) > ASYMMETRY * np.max(np.abs(product)):
            raise InputError(f"{letter} = -M A is not symmetric with this mass; give the mass of this building")
        symmetric.append(0.5 * (product + product.T))
    stiffness, damping = symmetric
    return Building(M, damping, stiffness, name)
