r"""The viscous Dahl model: a dashpot beside solid friction.

.. math:: F = k_x v + k_w w, \qquad \dot w = \rho (v - |v| w)

w is the friction in units of its Coulomb limit and stays in [-1, 1]; it forgets its past over a path of 1/rho, whatever
the speed. Along a monotone piece of path the step is exact: :math:`w_1 = s + (w_0 - s) e^{-\rho |\Delta x|}` with s the
direction. It cannot roll the force off near zero velocity: where a record shows that, add `hyperbolic_tangent`.

Equations (2.3) and (2.4) of Raminelli (2020); Dahl (1968); Ikhouane and Rodellar (2007).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, exp
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

STATES = {"w": (-1.0, 1.0)}  # the equation cannot leave it
EXAMPLE = {"kx": 1000.0, "kw": 300.0, "rho": 1000.0}


@checked
@dataclass(frozen=True)
class Dahl:
    """Viscous friction ``kx``, Coulomb friction ``kw`` and the reciprocal ``rho`` of the pre-sliding path."""

    kx: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    kw: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]


def advance(w: float, x0: float, x1: float, rho: float) -> float:
    s = copysign(1.0, x1 - x0)
    return s + (w - s) * exp(-rho * abs(x1 - x0))


def rates(w: float, v: float, rho: float) -> float:
    return rho * (v - abs(v) * w)


def switches(v: float) -> float:
    return v


def force(w: float, v: float, kx: float, kw: float) -> float:
    return kx * v + kw * w


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (0.3, 0.1, 0.03, 0.01):
        yield {"rho": 1.0 / (path * scale.stroke)}
