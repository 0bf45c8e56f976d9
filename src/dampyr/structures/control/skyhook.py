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

import numpy as np
from numpy.typing import NDArray

from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._sensed import absolute
from dampyr.units import Quantity


@checked
@dataclass(frozen=True)
class Skyhook:
    """The inputs ``low`` and ``high`` [V or A], the ``period`` between decisions and the ``lag`` of the coil [s], and the
    ``ratio`` of the skyhook's coefficient to the damper's greatest."""

    low: Annotated[float, Quantity("V or A")]
    high: Annotated[float, Quantity("V or A")]
    period: Annotated[float, Quantity("s", low=0, open_low=True)] = 0.005
    lag: Annotated[float, Quantity("s", low=0)] = 0.0
    ratio: Annotated[float, Quantity("", low=0, open_low=True)] = 1.0


def gains(law: Skyhook, building: Building, row: NDArray[np.float64]) -> NDArray[np.float64]:
    """The absolute velocity of the upper end."""
    return absolute(building, row)


def decide(signal: float, rate: float, low: float, high: float, ratio: float) -> float:
    if signal * rate <= 0.0:
        return low
    return low + (high - low) * min(1.0, ratio * signal / rate)
