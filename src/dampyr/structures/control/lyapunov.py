r"""Control by Lyapunov's function: full input while that makes a measure of the state fall faster.

.. math:: u = u_{max} H\{-z^T P B f\}, \qquad A^T P + P A = -Q

f [N] is the force of the damper as it is measured, :math:`z = (q, \dot q)` the whole state of the building relative to the
ground; :math:`\tfrac12 z^T P z` is the measure, whose fall the force of the damper hastens or hinders (A, B of the building
and of this damper alone, as in `state_space`). By default Q = diag(K, M); ``weights`` gives another diagonal of Q, 2n numbers,
displacements first, on which the result depends much: tune it. The input is ``low`` in the place of 0. Not for a building
that has no damping of its own in some mode, for which there is no P.

References: L. M. Jansen and S. J. Dyke, Semiactive control strategies for MR dampers: comparative study, Journal of
Engineering Mechanics 126 (2000) 795-803; after G. Leitmann, Semiactive control for vibration attenuation, Journal of
Intelligent Material Systems and Structures 5 (1994) 841-846.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._sensed import weighted
from dampyr.structures.propagator import system
from dampyr.units import Quantity


@checked
@dataclass(frozen=True)
class Lyapunov:
    """The inputs ``low`` and ``high`` [V or A], the ``period`` between decisions and the ``lag`` of the coil [s], and, where
    it is not the energy, the diagonal of Q in ``weights`` (2n,)."""

    low: Annotated[float, Quantity("V or A")]
    high: Annotated[float, Quantity("V or A")]
    period: Annotated[float, Quantity("s", low=0, open_low=True)] = 0.005
    lag: Annotated[float, Quantity("s", low=0)] = 0.0
    weights: tuple[float, ...] = ()


def gains(law: Lyapunov, building: Building, row: NDArray[np.float64]) -> NDArray[np.float64]:
    """-B^T P, and nothing of the ground's velocity."""
    from scipy.linalg import solve_continuous_lyapunov

    a, _, b = system(building, row[None])
    slowest = float(np.linalg.eigvals(a).real.max())
    if slowest > -1e-9 * float(np.abs(np.linalg.eigvals(a)).max()):
        raise InputError(
            f"{building.name} has a mode that does not decay by itself (real part {slowest:.3g} 1/s), so lyapunov has "
            "no P; give the building damping, or take bang_bang"
        )
    p = solve_continuous_lyapunov(a.T, -weighted(building, law.weights))
    return np.append(-(b.T @ p)[0], 0.0)


def decide(signal: float, force: float, low: float, high: float) -> float:
    return high if signal * force > 0.0 else low
