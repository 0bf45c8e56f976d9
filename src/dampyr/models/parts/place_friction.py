r"""Friction that depends on the place in the motion: of a seal, a guide or a side load.

.. math:: F = g \left(\frac{\ell z - y_0}{10\ \mathrm{mm}}\right)^2 \tanh\frac{v}{v_f}, \qquad
          \dot z = \frac{v - |v| z}{\ell}

:math:`\ell z` is the place as the damper remembers it: for a path short beside ell it is the position from where the motion
began, and it forgets over a path of ell, so that it finds the middle of the motion by itself. g is the friction 10 mm away
from the place y0 where it is least. Along a monotone piece of path the step is exact, as that of `dahl`, whose state z is
with :math:`\rho = 1/\ell`; z is 0 where a record begins and is not fitted: with a start of its own in each record ell would
grow without limit and z become a free zero of the displacement.

:math:`F v \ge 0` at every z: it only dissipates, alone and in any sum. Behind a `compliance` or `free_play` the force at a
sample is a single value while :math:`2 g y / (10\ \mathrm{mm})^2` times the stretch by a newton is below a half, y the
greatest distance from y0: 3 N/mm times 0.3 mm/kN is 0.001. ell at its limit of 1 m says "the place from where the motion
began, without memory"; an interval of g that holds 0 says that this damper shows none of it. It is an add-on: of the 38 sines
of the labcontrol campaign it takes away a quarter of the error that the best models had left, with g = 10 N and y0 = 5 mm at
all voltages alike; the sines of a second laboratory show none.

An equation of dampyr's own, from the residuals of that campaign; the state is that of Dahl (1968).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, exp, tanh
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True
CONSTANT = ("g", "y0", "ell", "vf")  # it is not the fluid's
RISES_IN_SERIES = True  # its slope by the place may be negative
STARTS_AT_REST = True
STATES = {"z": (-1.0, 1.0)}  # the equation cannot leave it
REACH = 0.010  # m from y0 at which the friction is g
EXAMPLE = {"g": 200.0, "y0": 0.004, "ell": 0.008, "vf": 0.002}


@checked
@dataclass(frozen=True)
class PlaceFriction:
    """The friction ``g`` 10 mm from the place ``y0`` where it is least, the memory ``ell`` and the velocity ``vf``."""

    g: Annotated[float, Quantity("N", low=0, linear=True)]
    y0: Annotated[float, Quantity("m")]
    ell: Annotated[float, Quantity("m", low=0, open_low=True, high=1)]
    vf: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def advance(z: float, x0: float, x1: float, ell: float) -> float:
    s = copysign(1.0, x1 - x0)
    return s + (z - s) * exp(-abs(x1 - x0) / ell)


def rates(z: float, v: float, ell: float) -> float:
    return (v - abs(v) * z) / ell


def switches(v: float) -> float:
    return v


def force(z: float, v: float, g: float, y0: float, ell: float, vf: float) -> float:
    return g * ((ell * z - y0) / REACH) ** 2 * tanh(v / vf)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.1, -0.1):
        yield {"y0": part * scale.stroke, "ell": scale.stroke, "vf": 0.02 * scale.speed}
