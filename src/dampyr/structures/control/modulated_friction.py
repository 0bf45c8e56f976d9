r"""Modulated homogeneous friction: the damper as a friction brake whose level is set anew at each turn of its stroke.

.. math:: u = u_{max} \text{ if } \lvert f\rvert < g\, \lvert P\rvert, \text{ else } u_{min}, \qquad P(t) = x(t_r)

P [m] is the stroke at the latest turn :math:`t_r`, so that the friction grows with the amplitude and its loops keep their
shape; f [N] is the force of the damper as it is measured. g [N/m] is ``ratio`` times the stiffness of the building between
the damper's ends. It needs a stroke and a force sensor and no model beyond that stiffness. A noisy stroke rate finds turns
where there are none: state the sensor's noise.

References: J. A. Inaudi, Modulated homogeneous friction: a semi-active damping strategy, Earthquake Engineering and Structural
Dynamics 26 (1997) 361-376; for dampers with two inputs L. M. Jansen and S. J. Dyke, Semiactive control strategies for MR
dampers: comparative study, Journal of Engineering Mechanics 126 (2000) 795-803.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._optimal import stiffness_between
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.units import Quantity

MEASURES = ("stroke", "rate", "force")
STATES = {"turned_at": 0.0, "rate_before": 0.0}


@checked
@dataclass(frozen=True)
class ModulatedFriction(ControlLaw):
    """``ratio``: g over the stiffness of the building between the damper's ends."""

    ratio: Annotated[float, Quantity("", low=0, open_low=True)] = 0.5


def design(law: ModulatedFriction, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The friction g x that a turn at this stroke would set."""
    return LawDesign({"level": np.array([law.ratio * stiffness_between(building, row), 0.0, 0.0])})


def update(level: float, rate: float, turned_at: float, rate_before: float) -> tuple[float, float]:
    return level if rate * rate_before <= 0.0 else turned_at, rate


def decide(turned_at: float, force: float, low: float, high: float) -> float:
    return high if abs(force) < abs(turned_at) else low
