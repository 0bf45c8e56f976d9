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
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.models.part import checked
from dampyr.structures.building import Building
from dampyr.structures.control._sensed import absolute
from dampyr.units import Quantity


@checked
@dataclass(frozen=True)
class OnOff:
    """The inputs ``low`` and ``high`` [V or A], the ``period`` between decisions and the ``lag`` of the coil [s]."""

    low: Annotated[float, Quantity("V or A")]
    high: Annotated[float, Quantity("V or A")]
    period: Annotated[float, Quantity("s", low=0, open_low=True)] = 0.005
    lag: Annotated[float, Quantity("s", low=0)] = 0.0


def gains(law: OnOff, building: Building, row: NDArray[np.float64]) -> NDArray[np.float64]:
    """The absolute velocity of the upper end."""
    return absolute(building, row)


def decide(signal: float, rate: float, low: float, high: float) -> float:
    return high if signal * rate > 0.0 else low
