r"""A compliance in series with the damper: mountings, rods and the fluid's own spring yield elastically under the force.

.. math:: F(t) = F_\text{other parts}(x - z), \qquad z = s F

The other parts feel the motion less the stretch z, the force is the same all along: Maxwell's arrangement. A stretch of
s = 0.5 mm/kN under 1 kN hides the first millimetre after each reversal from the piston. s = 0 is a rigid mounting. An
`inertia` is not behind it: it acts at the outer end, in parallel with the whole.

The force solves one equation at each sample, with u = v less the backward difference of z, of first order in the step. That
holds for every part whose force or memory depends on the velocity, also where it is exact or of second order by itself. A part
that depends on the path alone (`spring`, `gas_spring`; `dahl`, `maxwell_slip` and `bouc_wen` without their dashpots) is exact
in series too, at any step. The force is a state, 0 at the first sample unless a fit or ``state0`` says otherwise. Where s
follows the input and the input varies, the change of s alone moves no memory and is no velocity.

Maxwell (1867), Philosophical Transactions of the Royal Society 157, 49.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True
EXAMPLE = {"s": 6e-6}


@checked
@dataclass(frozen=True)
class Compliance:
    """The compliance ``s``, one over the stiffness of the element in series."""

    s: Annotated[float, Quantity("m/N", low=0)]


def stretch(f: float, s: float) -> float:
    return s * f


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    yield {"s": 1e-4 * scale.stroke / 100.0}
