r"""Clipped-optimal: full input while the damper gives less than the force that a linear optimal controller asks for.

.. math:: u = u_{max} H\{(f_c - f) f\}, \qquad f_c = -G z, \qquad G = R^{-1} B^T P

f [N] is the force of the damper as it is measured, :math:`z = (q, \dot q)` the whole state of the building relative to the
ground, and P solves :math:`A^T P + P A - P B R^{-1} B^T P + Q = 0`, which makes :math:`\int (z^T Q z + R f_c^2)\, dt`
least under white noise (A, B of the building and of this damper alone, as in `state_space`). By default Q = diag(K, M), twice
the energy of the building [J]; ``weights`` gives another diagonal of Q, 2n numbers, displacements first. R is ``effort``/k
[m/N], where k [N/m] is the stiffness of the building between the damper's ends: a smaller effort asks for more
force. The input is ``low`` in the place of 0. The whole state is taken as known, which an observer would only estimate; a
force asked for beyond the damper's reach, or against its motion, is clipped and not optimal. Not where the building is known
badly: see `bang_bang`.

References: S. J. Dyke, B. F. Spencer, M. K. Sain and J. D. Carlson, Modeling and control of magnetorheological dampers for
seismic response reduction, Smart Materials and Structures 5 (1996) 565-575, there with measured accelerations and an
observer.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._optimal import optimal_gains
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.units import Quantity

MEASURES = ("state", "force")


@checked
@dataclass(frozen=True)
class ClippedOptimal(ControlLaw):
    """The ``effort``, and the diagonal of Q in ``weights`` (2n,) where it is not the energy."""

    effort: Annotated[float, Quantity("", low=0, open_low=True)] = 0.01
    weights: tuple[float, ...] = ()


def design(law: ClippedOptimal, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The wanted force -G z."""
    return LawDesign({"wanted": np.append(-optimal_gains(building, row, law.effort, law.weights), 0.0)})


def decide(wanted: float, force: float, low: float, high: float) -> float:
    return high if (wanted - force) * force > 0.0 else low
