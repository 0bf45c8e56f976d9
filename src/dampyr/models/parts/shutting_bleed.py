r"""The damper with a bleed that shuts: after a reversal the fluid first passes beside the yielding gap.

.. math:: F = s\left((1-q)\frac{l h}{\sqrt{l^2 + h^2}} + q h\right), \quad s = \operatorname{sgn} v, \quad
          h = f_y \tanh\frac{|v|}{v_y} + c |v|, \quad l = b |v|, \quad q = \left(\frac{1 + s p}{2}\right)^4

h is the force of the gap, which the input changes, and l that of the bleed, which it does not; p, between -1 and 1, is how
far the valve has been moved, :math:`p \leftarrow \operatorname{clip}(p + \Delta x/d, -1, 1)`: just after a reversal q = 0 and
the two act one after the other, after a path of 2 d q = 1 and the bleed is shut. With d -> 0 or b -> infinity it is
`hyperbolic_tangent` with s = 0. The force rises with the velocity and with p, and :math:`F v \ge 0` at every p: it only
dissipates.

The step of p is exact. c, fy and b scale the force together and none of them alone, so that no parameter is linear. Let c, fy
and vy follow the input and b and d be constant: on the labcontrol campaign b is 46 N s/mm and d 0.16 mm.

An equation of dampyr's own, from the residuals of that campaign; p is the stop operator, as in Visintin (1994), Differential
Models of Hysteresis.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, sqrt, tanh
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.units import Quantity

CONSTANT = ("b", "d")
SCALE_TOGETHER = ("c", "fy", "b")
STATES = {"p": (-1.0, 1.0)}  # held there
SMALL = 1e-12  # m/s, beside which no vy is small: h/|v| has a limit at rest, where both are 0
EXAMPLE = {"c": 1500.0, "fy": 300.0, "vy": 0.005, "b": 12e3, "d": 0.003}


@checked
@dataclass(frozen=True)
class ShuttingBleed:
    """Damping ``c`` and friction ``fy`` of the gap, its velocity ``vy``, the bleed ``b`` and ``d``, half its shutting path."""

    c: Annotated[float, Quantity("N s/m", low=0)]
    fy: Annotated[float, Quantity("N", low=0)]
    vy: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    b: Annotated[float, Quantity("N s/m", low=0, open_low=True)]
    d: Annotated[float, Quantity("m", low=0, open_low=True)]


def advance(p: float, x0: float, x1: float, d: float) -> float:
    return slip(p, (x1 - x0) / d)


def force(p: float, v: float, c: float, fy: float, vy: float, b: float) -> float:
    s = copysign(1.0, v)
    gap = fy * tanh(abs(v) / vy) + c * abs(v)
    ratio = fy * tanh((abs(v) + SMALL) / vy) / (abs(v) + SMALL) + c
    q = (0.5 * (1.0 + s * p)) ** 4
    return s * gap * ((1.0 - q) * b / sqrt(b * b + ratio * ratio) + q)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.02, 0.1):
        speed = part * scale.speed
        fy = 0.7 * scale.force
        yield {"c": 0.3 * scale.force / scale.speed, "fy": fy, "vy": speed, "b": fy / speed, "d": 0.005 * scale.stroke}
