r"""Clipped-optimal control as Quiroz (2022) has it: without a look at the sign, one sample late.

.. math:: i = i_{max} \text{ if } |f_c| > |f|, \text{ else } i_{min}, \qquad f_c = -G \hat z

G is of linear optimal control with the weight 1e13 on the roof's displacement [m] and 1 on the force [N]; :math:`\hat z` of a
Kalman filter on the three absolute accelerations and the force, with the spectral densities 0.1 of the ground's acceleration
and 5e-4 of the accelerometers: at a period T their variances are :math:`0.1/T` and :math:`5\cdot10^{-4}/T`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.structures.building import Building
from dampyr.structures.control._optimal import optimal_gains, state_filter, stiffness_between
from dampyr.structures.law_form import ControlLaw, LawDesign

MEASURES = ("accelerations", "force")
ROOF, DISTURBANCE, NOISE = 1e13, 0.1, 5e-4


@dataclass(frozen=True)
class QuirozLaw(ControlLaw):
    """The settings of every law, and no others."""


def design(law: QuirozLaw, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The wanted force of the estimate, and the filter."""
    weights = np.zeros(2 * building.n)
    weights[building.n - 1] = ROOF
    gains = optimal_gains(building, row, stiffness_between(building, row), tuple(weights))
    spread = (np.sqrt(density / law.period) for density in (NOISE, DISTURBANCE))
    estimate, F, G = state_filter(building, row, law.period, *spread)
    return LawDesign({"wanted": -gains @ estimate}, F, G)


def decide(wanted: float, force: float, low: float, high: float) -> float:
    return high if abs(wanted) > abs(force) else low
