r"""On-off skyhook: full input while the damper pulls the mass towards rest, the least otherwise.

.. math:: u = u_{max} \text{ if } \dot y\, \dot x > 0, \text{ else } u_{min}

:math:`\dot y` [m/s] is the absolute velocity of the floor at the damper's upper end, :math:`\dot x` [m/s] the rate of its
stroke, both counted positive where they lengthen the damper. It wants two velocities and no model of the building. Not for a
motion whose own velocity drifts, which the absolute velocity is summed from (correct it first); not where accelerations
matter most, as every switch is a jerk.

References: D. Karnopp, M. J. Crosby and R. A. Harwood, Vibration control using semi-active force generators, Journal of
Engineering for Industry 96 (1974) 619-626; in two states E. J. Krasnicki, Comparison of analytical and experimental results
for a semi-active vibration isolator, Shock and Vibration Bulletin 50 (1980) 69-76.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw

MEASURES = ("velocity", "rate")


@checked
@dataclass(frozen=True)
class OnOff(ControlLaw):
    """The settings of every law, and no others."""


def decide(velocity: float, rate: float, low: float, high: float) -> float:
    return high if velocity * rate > 0.0 else low
