r"""Hybrid of skyhook and groundhook: a weighted sum of what each of the two asks for, continuously.

.. math:: u = u_{min} + (u_{max} - u_{min}) \min\big(1,
          r\,[\alpha\, (\dot y/\dot x)^+ + (1 - \alpha)\, (\dot y_l/\dot x)^+]\big)

:math:`\dot y` and :math:`\dot y_l` [m/s] are the absolute velocities of the damper's upper and lower end, :math:`\dot x`
[m/s] the rate of its stroke, all counted positive where they lengthen the damper, and :math:`(\cdot)^+` is 0 for what is
negative. The ``share`` :math:`\alpha` is 1 for skyhook, 0 for groundhook; r (``ratio``) is the wanted coefficient over the
damper's greatest, which is taken as if it grew linearly with the input. Not for a damper on the ground (see `groundhook`).

Reference: M. Ahmadian, A hybrid semiactive control for secondary suspension applications, ASME Dynamic Systems and Control 61
(1997) 743-750.
"""

from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw
from dampyr.units import Quantity

MEASURES = ("velocity", "lower_velocity", "rate")


@checked
@dataclass(frozen=True)
class HybridHook(ControlLaw):
    """``share`` of skyhook in the sum, and ``ratio``: the wanted coefficient over the damper's greatest."""

    share: Annotated[float, Quantity("", low=0, high=1)] = 0.5
    ratio: Annotated[float, Quantity("", low=0, open_low=True)] = 1.0


def decide(
    velocity: float, lower_velocity: float, rate: float, low: float, high: float, share: float, ratio: float
) -> float:
    return low + (high - low) * min(
        1.0,
        ratio
        * (
            (share * velocity / rate if velocity * rate > 0.0 else 0.0)
            + ((1.0 - share) * lower_velocity / rate if lower_velocity * rate > 0.0 else 0.0)
        ),
    )
