r"""The nonlinear biviscous model: a steep dashpot before yield, a flat one after it.

.. math:: F = c\,v + f_y \begin{cases} v/v_y & |v| \le v_y \\ \operatorname{sgn} v & |v| > v_y \end{cases}

In the letters of the source the post-yield damping is :math:`C_{po} = c`, the pre-yield damping
:math:`C_{pr} = c + f_y/v_y` and the yield force :math:`F_y = f_y`, met at :math:`v_y = F_y/(C_{pr} - C_{po})`; written this way
Cpr > Cpo always. With vy -> 0 it is the Bingham model as published. It has no memory: where the record shows a loop in
the force-velocity plane use `hysteretic_biviscous`, `dahl` or `bouc_wen`.

Stanway, Sproston and El-Wahed (1996), Smart Materials and Structures 5, 464; Wereley, Pang and Park (1998), Journal of
Intelligent Material Systems and Structures 9, 642.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

EXAMPLE = {"c": 1500.0, "fy": 300.0, "vy": 0.02}


@checked
@dataclass(frozen=True)
class Biviscous:
    """Post-yield damping ``c``, yield force ``fy`` and the velocity ``vy`` of yield."""

    c: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    fy: Annotated[float, Quantity("N", low=0, linear=True)]
    vy: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def force(v: float, c: float, fy: float, vy: float) -> float:
    if abs(v) <= vy:
        return c * v + fy * v / vy
    return c * v + fy * copysign(1.0, v)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.5, 0.2, 0.07):
        yield {"vy": part * scale.speed}
