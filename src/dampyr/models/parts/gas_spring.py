r"""The gas spring: the accumulator, as its gas is compressed and let go.

.. math:: F = f_0\left(1 - \left(1 + \frac{x}{L}\right)^{-\gamma}\right), \qquad x > -L

f0 is the force with which the gas pushes the rod out at x = 0, that is the pressure times the rod's section; L is the
volume of the gas over that section, the stroke by which compression would close it; gamma is the polytropic exponent,
from 1 (slow) to 1.4 (fast, nitrogen). The push itself, -f0, is static: it is the `offset`, and here the force at x = 0
is zero. The stiffness there is :math:`\gamma f_0/L`; for strokes far below L the part is a `spring`, and a record determines
f0, L and gamma only by the curvature that it shows: hold gamma, and L if it is known (``fixed=``). At x = -L and below
there is no gas volume left and the force is not a number.

The law of a polytropic gas, p V**gamma = constant.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import exp, log
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True
EXAMPLE = {"f0": 150.0, "L": 0.03, "gamma": 1.3}


@checked
@dataclass(frozen=True)
class GasSpring:
    """The push ``f0`` of the gas at x = 0, the length ``L`` of its column and the polytropic exponent ``gamma``."""

    f0: Annotated[float, Quantity("N", low=0, linear=True)]
    L: Annotated[float, Quantity("m", low=0, open_low=True)]
    gamma: Annotated[float, Quantity("", low=1)]


def force(x: float, f0: float, L: float, gamma: float) -> float:
    return f0 * (1.0 - exp(-gamma * log(1.0 + x / L)))


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for length in (1.0, 3.0, 10.0):
        yield {"L": length * scale.stroke, "gamma": 1.2}
