r"""Passive-off: the least input at all times.

.. math:: u = u_{min}

What remains of a controlled damper when its power fails, and one of the two cases that a controller has to be better than.

Reference: S. J. Dyke, B. F. Spencer, M. K. Sain and J. D. Carlson, Modeling and control of magnetorheological dampers for
seismic response reduction, Smart Materials and Structures 5 (1996) 565-575.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw


@checked
@dataclass(frozen=True)
class PassiveOff(ControlLaw):
    """The settings of every law, and no others."""


def decide(low: float) -> float:
    return low
