r"""Maximum energy dissipation: full input while the damper's force opposes its own stroke.

.. math:: u = u_{max} \text{ if } \dot x f > 0, \text{ else } u_{min}

f [N] is the force of the damper as it is measured, :math:`\dot x` [m/s] the rate of its stroke. What falls fastest is the
energy of the motion relative to the ground, :math:`\tfrac12 q^T K q + \tfrac12 \dot q^T M \dot q`. It needs no model of the
building. A damper nearly always opposes its stroke, so it is close to full input; only the elastic part of the force makes it
switch.

Reference: L. M. Jansen and S. J. Dyke, Semiactive control strategies for MR dampers: comparative study, Journal of Engineering
Mechanics 126 (2000) 795-803.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw

MEASURES = ("rate", "force")


@checked
@dataclass(frozen=True)
class MaximumDissipation(ControlLaw):
    """The settings of every law, and no others."""


def decide(rate: float, force: float, low: float, high: float) -> float:
    return high if rate * force > 0.0 else low
