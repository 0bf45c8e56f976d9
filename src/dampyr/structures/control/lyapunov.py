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

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._optimal import weighted
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.structures.propagator import system

MEASURES = ("state", "force")


@checked
@dataclass(frozen=True)
class Lyapunov(ControlLaw):
    """The diagonal of Q in ``weights`` (2n,) where it is not the energy."""

    weights: tuple[float, ...] = ()


def design(law: Lyapunov, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The rate at which the damper's force makes the measure grow, over that force: -B^T P z."""
    from scipy.linalg import solve_continuous_lyapunov

    a, _, b = system(building, row[None])
    slowest = float(np.linalg.eigvals(a).real.max())
    if slowest > -1e-9 * float(np.abs(np.linalg.eigvals(a)).max()):
        raise InputError(
            f"{building.name} has a mode that does not decay by itself (real part {slowest:.3g} 1/s), so lyapunov has "
            "no P; give the building damping, or take bang_bang"
        )
    p = solve_continuous_lyapunov(a.T, -weighted(building, law.weights))
    return LawDesign({"fall": np.append(-(b.T @ p)[0], 0.0)})


def decide(fall: float, force: float, low: float, high: float) -> float:
    return high if fall * force > 0.0 else low
