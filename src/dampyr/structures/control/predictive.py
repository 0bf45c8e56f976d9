r"""Predictive control over a short horizon: full input while more force would lower the cost that a model predicts.

.. math:: u = u_{max} \text{ if } (f^* - f) f > 0, \text{ else } u_{min}, \qquad
          f^* = \arg\min_f \Big[\sum_{j=1}^{N} z_j^T Q z_j + N R f^2\Big], \qquad z_{j+1} = \Phi z_j + \Gamma f + \Gamma_g\, a_j

z [m, m/s] is the state of the building relative to the ground, taken as known; :math:`\Phi`, :math:`\Gamma` and
:math:`\Gamma_g` are of the building with this damper alone over a period of the law, and N periods are the ``horizon``. The
force is held over it, so that the cost is a parabola: where the damper's measured force f [N] lies short of its lowest point
:math:`f^*`, more of it lowers the cost, beyond it less. :math:`a_j` is the measured acceleration of the ground times the share
``ground`` that stays over the horizon: 1 holds it, 0 knows nothing of it, which on ground motions does much worse. Q and R are
those of `clipped_optimal`, whose horizon has no end. A horizon of more than a quarter of the building's periods holds a force
that should turn before.

References: G. Mei, A. Kareem and J. C. Kantor, Real-time model predictive control of structures under earthquakes, Earthquake
Engineering and Structural Dynamics 30 (2001) 995-1019, with actuators and a model of the ground; the clipping is that of S. J.
Dyke, B. F. Spencer, M. K. Sain and J. D. Carlson, Modeling and control of magnetorheological dampers for seismic response
reduction, Smart Materials and Structures 5 (1996) 565-575.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._optimal import held_steps, stiffness_between, weighted
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.units import Quantity

MEASURES = ("state", "force", "ground_acceleration")


@checked
@dataclass(frozen=True)
class Predictive(ControlLaw):
    """The ``horizon`` [s], the share of the ``ground``'s acceleration that stays over it; ``effort`` and ``weights`` as in
    clipped_optimal."""

    horizon: Annotated[float, Quantity("s", low=0, open_low=True)] = 0.1
    ground: Annotated[float, Quantity("", low=0, high=1)] = 1.0
    effort: Annotated[float, Quantity("", low=0, open_low=True)] = 0.01
    weights: tuple[float, ...] = ()


def design(law: Predictive, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The held force of the lowest predicted cost, of the state and the ground's acceleration."""
    steps = round(law.horizon / law.period)
    if not 1 <= steps <= 10_000:
        raise InputError(
            f"horizon = {law.horizon:g} s of predictive is {law.horizon / law.period:.3g} of its periods of {law.period:g} s; "
            "give 1 to 10,000 of them"
        )
    phi, gamma, push = held_steps(building, row, law.period)
    Q: NDArray[np.float64] = weighted(building, law.weights)
    of_state, of_force, of_ground = np.eye(len(phi)), np.zeros(len(phi)), np.zeros(len(phi))
    curvature = steps * law.effort / stiffness_between(building, row)
    slope, slope_by_ground = np.zeros(len(phi)), 0.0
    for _ in range(steps):
        of_state, of_force, of_ground = phi @ of_state, phi @ of_force + gamma, phi @ of_ground + push
        curvature += float(of_force @ Q @ of_force)
        slope = slope + of_force @ Q @ of_state
        slope_by_ground += float(of_force @ Q @ of_ground)
    return LawDesign({"lowest": -np.concatenate([slope, [0.0, law.ground * slope_by_ground]]) / curvature})


def decide(lowest: float, force: float, low: float, high: float) -> float:
    return high if (lowest - force) * force > 0.0 else low
