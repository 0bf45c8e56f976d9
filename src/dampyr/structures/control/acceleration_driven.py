r"""Acceleration-driven: full input while the damper pushes against the acceleration of its upper end, the least otherwise.

.. math:: u = u_{max} \text{ if } \ddot y\, \dot x > 0, \text{ else } u_{min}

:math:`\ddot y` [m/s2] is the absolute acceleration of the damper's upper end, :math:`\dot x` [m/s] the rate of its stroke, both
counted positive where they lengthen the damper. It makes the acceleration at the next instant least, so it is good above the
natural frequency and poor at it; it needs an accelerometer and a stroke sensor and no model. It switches with every sign of a
noisy acceleration: state the sensor's noise.

Reference: S. M. Savaresi, E. Silani and S. Bittanti, Acceleration-driven-damper (ADD): an optimal control algorithm for
comfort-oriented semiactive suspensions, Journal of Dynamic Systems, Measurement, and Control 127 (2005) 218-229.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw

MEASURES = ("acceleration", "rate")


@checked
@dataclass(frozen=True)
class AccelerationDriven(ControlLaw):
    """The settings of every law, and no others."""


def decide(acceleration: float, rate: float, low: float, high: float) -> float:
    return high if acceleration * rate > 0.0 else low
