r"""Inverse-model force tracking: the input at which the damper gives the force that a linear optimal controller asks for.

.. math:: u = \arg\min_{low \le u \le high} |F(u) - f_c|, \qquad f_c = -G z, \qquad G = R^{-1} B^T P

F is the force of the damper's own model a period later, the rate of its stroke staying as it is, run backwards with its memory
and its coil (`dampyr.structures.wanted_force`); G is the gain of `clipped_optimal`, :math:`z = (q, \dot q)` the state of the
building relative to the ground, taken as known. The force sensor of `clipped_optimal` is not needed, but the stroke and its
rate are, which the model follows. The input is continuous, where `clipped_optimal` has two values. Where no input gives the
wanted force, as with the wrong sign a third of the time and more, the nearest is taken; a response says how often
(``wanted_forces``). Not where the damper is known badly: nothing is measured that would correct its model.

References: C. C. Chang and L. Zhou, Neural network emulation of inverse dynamics for a magnetorheological damper, Journal of
Structural Engineering 128 (2002) 231-239; H. H. Tsang, R. K. L. Su and A. M. Chandler, Simplified inverse dynamics models for
MR fluid dampers, Engineering Structures 28 (2006) 327-341, both with inverses that were fitted or simplified.
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

MEASURES = ("state", "stroke", "rate")
ASKS = "force"


@checked
@dataclass(frozen=True)
class InverseTracking(ControlLaw):
    """The ``effort`` and ``weights`` of clipped_optimal."""

    effort: Annotated[float, Quantity("", low=0, open_low=True)] = 0.01
    weights: tuple[float, ...] = ()


def design(law: InverseTracking, building: Building, row: NDArray[np.float64]) -> LawDesign:
    """The wanted force -G z."""
    return LawDesign({"wanted": np.append(-optimal_gains(building, row, law.effort, law.weights), [0.0, 0.0])})


def decide(wanted: float) -> float:
    return wanted
