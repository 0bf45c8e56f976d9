r"""Sliding mode: full input while the damper gives less than the force that leads the state to a surface and keeps it there.

.. math:: u = u_{max} \text{ if } (f_c - f) f > 0, \text{ else } u_{min}, \qquad
          f_c = -S A z - \kappa\, S z - \delta\, \mathrm{sgn}(S z), \qquad S = G/(G B)

f [N] is the force of the damper as it is measured, :math:`z = (q, \dot q)` the state of the building relative to the ground. On
the surface :math:`S z = 0` the motion is that of linear optimal control with much force (G of `clipped_optimal`; A, B of the
building and of this damper alone); the first term keeps it there, the others lead to it, with the rate ``reach`` :math:`\kappa`
[1/s] and the ``switching`` force :math:`\delta` [N], which outweighs what the model does not know. The whole state is taken as
known.

References: J. N. Yang, J. C. Wu and A. K. Agrawal, Sliding mode control for nonlinear and hysteretic structures, Journal of
Engineering Mechanics 121 (1995) 1330-1339; W. Gao and J. C. Hung, Variable structure control of nonlinear systems: a new
approach, IEEE Transactions on Industrial Electronics 40 (1993) 45-55, for the way to the surface.
"""

from dataclasses import dataclass
from math import copysign
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._optimal import optimal_gains
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.structures.propagator import system
from dampyr.units import Quantity

MEASURES = ("state", "force")


@checked
@dataclass(frozen=True)
class SlidingMode(ControlLaw):
    """The ``reach`` of the surface [1/s] and the ``switching`` force [N]; ``effort`` and ``weights`` as in clipped_optimal."""

    reach: Annotated[float, Quantity("1/s", low=0)] = 20.0
    switching: Annotated[float, Quantity("N", low=0)] = 0.0
    effort: Annotated[float, Quantity("", low=0, open_low=True)] = 0.01
    weights: tuple[float, ...] = ()


def design(law: SlidingMode, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """S z, and the force that keeps it as it is, -S A z."""
    a, _, b = system(building, row[None])
    gains = optimal_gains(building, row, law.effort, law.weights)
    surface = gains / float(gains @ b[:, 0])
    return LawDesign({"surface": np.append(surface, 0.0), "keeping": np.append(-surface @ a, 0.0)})


def decide(
    surface: float, keeping: float, force: float, low: float, high: float, reach: float, switching: float
) -> float:
    return high if (keeping - reach * surface - switching * copysign(1.0, surface) - force) * force > 0.0 else low
