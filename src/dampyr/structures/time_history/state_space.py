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
from numpy.typing import NDArray

from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.structures.propagator import system

Array = NDArray[np.float64]


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


def state_space(building: Building, storey: int | Sequence[Any] = 1) -> StateSpace:
    """Equations (5.3) to (5.6) for dampers in one storey or a list of places, each a storey or two floors.

    Lambda holds -1 on the floor above the damper and +1 on the one below: a force that opposes the growth
    of the drift is positive. A reduced structure is taken as it is given: with `refined` it has the coordinates that responses
    take, and n is their number.
    """
    n = building.n
    places = storey if isinstance(storey, Sequence) else [storey]
    rows = np.array([building.connection(place) for place in places]).reshape(-1, n)
    a, e, b = system(building, rows)
    floors = slice(n, n + building.n_floors)
    return StateSpace(
        a, b, e, a[floors].copy(), b[floors].copy(), -rows.T, building.ground_terms()[0][: building.n_floors]
    )
