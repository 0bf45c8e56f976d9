r"""Passive-on: the greatest input at all times.

.. math:: u = u_{max}

The other case that a controller has to be better than: with a strong damper it locks a storey, and accelerations rise.

Reference: S. J. Dyke, B. F. Spencer, M. K. Sain and J. D. Carlson, Modeling and control of magnetorheological dampers for
seismic response reduction, Smart Materials and Structures 5 (1996) 565-575.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw


@checked
@dataclass(frozen=True)
class PassiveOn(ControlLaw):
    """The settings of every law, and no others."""


def decide(high: float) -> float:
    return high
