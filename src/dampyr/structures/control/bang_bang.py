r"""Decentralised bang-bang: full input while the damper takes energy from the building's absolute motion.

.. math:: u = u_{max} \text{ if } \dot s f > 0, \text{ else } u_{min}, \qquad
          \dot s = \lambda^T (\dot q + \iota\, \dot x_g)

f [N] is the force of the damper as it is measured, :math:`\dot s` [m/s] the rate at which it lengthens where the ground
counts as still: for a damper on the ground the absolute velocity of its floor, for any other the rate of its stroke.
What falls fastest is :math:`\tfrac12 q^T K q + \tfrac12 (\dot q + \iota \dot x_g)^T M (\dot q + \iota \dot x_g)`. It
needs no model of the building. A damper between two floors nearly always opposes its own stroke, so there the law hardly
differs from full input always.

References: N. H. McClamroch and H. P. Gavin, Closed loop structural control using electrorheological dampers, American
Control Conference (1995) 4173-4177; L. M. Jansen and S. J. Dyke, Semiactive control strategies for MR dampers: comparative
study, Journal of Engineering Mechanics 126 (2000) 795-803.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw

MEASURES = ("absolute_rate", "force")


@checked
@dataclass(frozen=True)
class BangBang(ControlLaw):
    """The settings of every law, and no others."""


def decide(absolute_rate: float, force: float, low: float, high: float) -> float:
    return high if absolute_rate * force > 0.0 else low
