r"""The polynomial model of Choi, Lee and Park: a polynomial of the velocity for each sign of the acceleration.

.. math:: F = p_1 u + p_3 u^3 + p_5 u^5 + w\,(p_0 + p_2 u^2 + p_4 u^4 + p_6 u^6), \qquad u = \frac{v}{0.1\ \mathrm{m/s}},
          \qquad \dot w = \begin{cases} \dot v/v_h & \text{while } -1 < w < 1 \\ 0 & \text{where } w \text{ is held at } \pm 1
          \end{cases}

The source writes :math:`F = \sum_{i=0}^6 a_i v^i` with one set of numbers where the acceleration is positive, w = 1 here, and
another where it is negative; as a damper that is turned round is the same, the second is :math:`(-1)^{i+1} a_i`, and what is
unlike in the two directions is `offset` and `gas_spring`. Its numbers are linear in the current: give a fit
``laws={"*": "polynomial:1"}``. Each p is the force of its power at 0.1 m/s.

In the source the force jumps by :math:`2\,(p_0 + p_2 u^2 + \dots)` where the acceleration changes its sign, and noise of the
velocity makes it jump there and back. With w, as in `hysteretic_biviscous`, it follows the velocity over 2 vh after a reversal:
with vh -> 0 it is the published force. The step is exact while the velocity is monotone between samples.

It describes records and nothing beyond. Do not use it for a building: above the greatest speed of its records the sixth power
takes over at once, and nothing makes it passive. Behind a `compliance` its force has one value only where it does not fall
with the velocity.

Choi, Lee and Park (2001), Journal of Sound and Vibration 245, 375.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.units import Quantity

NOT_FOR_BUILDINGS = (
    "its polynomial holds up to the speed of its records and may push; use dahl, bouc_wen or modified_bouc_wen"
)
RISES_IN_SERIES = True  # where a fit has made it fall with the velocity
STATES = {"w": (-1.0, 1.0)}  # the equation cannot leave it
UNIT = 0.1  # m/s
EXAMPLE = {"p0": 0.0, "p1": 600.0, "p2": 0.0, "p3": -250.0, "p4": 0.0, "p5": 45.0, "p6": 0.0, "vh": 0.06}


@checked
@dataclass(frozen=True)
class ChoiPolynomial:
    """Forces ``p0`` to ``p6`` of the powers of the velocity at 0.1 m/s, and the shift ``vh``."""

    p0: Annotated[float, Quantity("N", linear=True)]
    p1: Annotated[float, Quantity("N", linear=True)]
    p2: Annotated[float, Quantity("N", linear=True)]
    p3: Annotated[float, Quantity("N", linear=True)]
    p4: Annotated[float, Quantity("N", linear=True)]
    p5: Annotated[float, Quantity("N", linear=True)]
    p6: Annotated[float, Quantity("N", linear=True)]
    vh: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def advance(w: float, v0: float, v1: float, vh: float) -> float:
    return slip(w, (v1 - v0) / vh)


def force(
    w: float, v: float, p0: float, p1: float, p2: float, p3: float, p4: float, p5: float, p6: float
) -> float:  # fmt: skip
    u = v / UNIT
    s = u * u
    return u * (p1 + s * (p3 + s * p5)) + w * (p0 + s * (p2 + s * (p4 + s * p6)))


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for shift in (0.2, 0.05, 0.01):
        yield {"vh": shift * scale.speed}
