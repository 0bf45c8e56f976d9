r"""Free play in series with the damper: a joint whose pin has clearance in its eye.

.. math:: F(t) = F_\text{other parts}(x - z), \qquad z = g \frac{F}{\sqrt{F^2 + f_c^2}}

The pin lies against one side of the eye or the other, at z = +-g, wherever the force is large beside fc, and crosses the gap
2 g as the force changes sign; fc is the force that closes 71 % of the gap and rounds the crossing. g = 0 is a tight
joint. It acts in series as `compliance` does, with the same order of the step, and one damper can have both.

The dead band of a joint in series with a spring, as in Tao and Kokotovic (1996), Adaptive Control of Systems with Actuator
and Sensor Nonlinearities; rounded here, so that the force is a single value.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True
EXAMPLE = {"g": 0.003, "fc": 20.0}


@checked
@dataclass(frozen=True)
class FreePlay:
    """Half of the gap ``g``, and the force ``fc`` that closes 71 % of it."""

    g: Annotated[float, Quantity("m", low=0)]
    fc: Annotated[float, Quantity("N", low=0, open_low=True)]


def stretch(f: float, g: float, fc: float) -> float:
    return g * f / sqrt(f * f + fc * fc)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    yield {"g": 0.001 * scale.stroke, "fc": 10.0}
