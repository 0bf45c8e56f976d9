r"""The hysteretic biviscous model: `biviscous` whose yield comes later on the way up than on the way down.

.. math:: F = c\,v + f_y \operatorname{sat}\frac{v - v_h w}{v_y}, \qquad
          \dot w = \begin{cases} \dot v/v_h & \text{while } -1 < w < 1 \\ 0 & \text{where } w \text{ is held at } \pm 1
          \end{cases}

sat is the identity between -1 and 1 and holds these values beyond. w is 1 while the velocity rises and -1 while it falls,
once it has moved by 2 vh since it turned. The source writes the sign of the acceleration in the place of w, with

.. math:: C_{po} = c, \quad C_{pr} = c + f_y/v_y, \quad F_y = f_y, \quad v_0 = v_h (C_{pr} - C_{po})/C_{pr}

A cycle that yields, that is, whose peak velocity is vy + vh or more, gives the published force to the letter.
In smaller cycles the published force jumps where the acceleration changes its sign; with w it is continuous.

The step is exact while the velocity is monotone between samples. Do not use it for a building: the shift was read off
cycles of sine and has no energy balance, so at a velocity within vh of zero it may push (a building's response warns
where it did on the whole); there use `dahl`, `bouc_wen` or `modified_bouc_wen`.

Wereley, Pang and Park (1998), Journal of Intelligent Material Systems and Structures 9, 642.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.units import Quantity

NOT_FOR_BUILDINGS = (
    "its shift was read off cycles of sine and has no energy balance, so it may push; "
    "use dahl, bouc_wen or modified_bouc_wen"
)
STATES = {"w": (-1.0, 1.0)}  # the equation cannot leave it
EXAMPLE = {"c": 1200.0, "fy": 300.0, "vy": 0.02, "vh": 0.012}


@checked
@dataclass(frozen=True)
class HystereticBiviscous:
    """Post-yield damping ``c``, yield force ``fy``, its velocity ``vy`` without the shift, and the shift ``vh``."""

    c: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    fy: Annotated[float, Quantity("N", low=0, linear=True)]
    vy: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    vh: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def advance(w: float, v0: float, v1: float, vh: float) -> float:
    return slip(w, (v1 - v0) / vh)


def force(w: float, v: float, c: float, fy: float, vy: float, vh: float) -> float:
    return c * v + fy * slip(0.0, (v - vh * w) / vy)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.4, 0.15):
        for shift in (0.2, 0.05):
            yield {"vy": part * scale.speed, "vh": shift * scale.speed}
