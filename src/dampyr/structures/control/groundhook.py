r"""On-off groundhook: full input while the damper pulls its lower end towards rest, the least otherwise.

.. math:: u = u_{max} \text{ if } \dot y_l\, \dot x > 0, \text{ else } u_{min}

:math:`\dot y_l` [m/s] is the absolute velocity of the damper's lower end, a wheel or a floor, :math:`\dot x` [m/s] the rate
of its stroke, both counted positive where they lengthen the damper. It keeps wheels on the road, at the cost of comfort. Of a
damper on the ground the lower end is the ground itself, which no damper brings to rest: take `on_off` there.

Reference: M. Valasek, M. Novak, Z. Sika and O. Vaculin, Extended ground-hook: new concept of semi-active control of truck's
suspension, Vehicle System Dynamics 27 (1997) 289-303.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw

MEASURES = ("lower_velocity", "rate")


@checked
@dataclass(frozen=True)
class Groundhook(ControlLaw):
    """The settings of every law, and no others."""


def decide(lower_velocity: float, rate: float, low: float, high: float) -> float:
    return high if lower_velocity * rate > 0.0 else low
