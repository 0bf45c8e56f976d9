r"""Continuous skyhook: as much input as makes the damper act like one between the mass and the sky.

.. math:: u = u_{min} + (u_{max} - u_{min}) \min(1, r\, \dot y/\dot x) \text{ if } \dot y\, \dot x > 0,
          \text{ else } u_{min}

:math:`\dot y` [m/s] is the absolute velocity of the floor at the damper's upper end, :math:`\dot x` [m/s] the rate of its
stroke, both counted positive where they lengthen the damper; r (``ratio``) is the coefficient of the wanted skyhook over the
greatest of the damper. The damping is taken as if it grew linearly with the input, which no magnetorheological damper does
exactly: the force is near the skyhook's, not equal to it. Not for a motion whose own velocity drifts; for a target force
that is met more closely see `clipped_optimal`.

Reference: D. Karnopp, M. J. Crosby and R. A. Harwood, Vibration control using semi-active force generators, Journal of
Engineering for Industry 96 (1974) 619-626.
"""

from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw
from dampyr.units import Quantity

MEASURES = ("velocity", "rate")


@checked
@dataclass(frozen=True)
class Skyhook(ControlLaw):
    """``ratio``: the skyhook's coefficient over the damper's greatest."""

    ratio: Annotated[float, Quantity("", low=0, open_low=True)] = 1.0


def decide(velocity: float, rate: float, low: float, high: float, ratio: float) -> float:
    return low + (high - low) * min(1.0, ratio * velocity / rate) if velocity * rate > 0.0 else low
