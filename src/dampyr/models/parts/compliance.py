r"""A compliance in series with the damper: mountings, rods and the fluid's own spring yield elastically under the force.

.. math:: F(t) = F_\text{other parts}(x - z), \qquad z = s F

The other parts feel the motion less the stretch z, the force is the same all along: Maxwell's arrangement. A stretch of
s = 0.5 mm/kN under 1 kN hides the first millimetre after each reversal from the piston. s = 0 is a rigid mounting. The
force solves one equation at each sample; the rate of the stretch is its backward difference, of first order in the step.

Maxwell (1867), Philosophical Transactions of the Royal Society 157, 49.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True


@checked
@dataclass(frozen=True)
class Compliance:
    """The compliance ``s``, one over the stiffness of the element in series."""

    s: Annotated[float, Quantity("m/N", low=0)]


def stretch(f: float, s: float) -> float:
    return s * f


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    yield {"s": 1e-4 * scale.stroke / 100.0}
