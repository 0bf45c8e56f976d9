r"""The triple friction pendulum bearing, in one horizontal direction and under a constant load: three sliders in series.

.. math:: F = f_1 \frac{x - u_1 - u_2 - u_3}{u_y}, \qquad
          |F/f_1 - u_i/\ell_i| \le r_i, \quad |u_i| \le d_i, \qquad r_1 = 1

of base isolation. Each of the three moves by :math:`u_i` where the force less that of its pendulum, :math:`f_1 u_i/\ell_i`,
reaches its friction :math:`r_i f_1`, and not beyond its stop :math:`d_i`; the same force goes through all, and through an
elastic spring that moves by :math:`u_y` under :math:`f_1`. Beyond all stops that spring is left. In the letters of the source
:math:`f_1 = \bar\mu_1 W`, :math:`r_i = \bar\mu_i/\bar\mu_1` and :math:`\ell_i = \bar\mu_1 \bar R_i`; W, the friction and the
radii scale together, so that W is not among the numbers. `from_bearing` makes them of the four surfaces of a bearing:

.. math:: \bar R_1 = R_2 + R_3, \quad \bar R_2 = R_1 - R_2, \quad \bar R_3 = R_4 - R_3, \quad
          \bar\mu = (\mu_2, \mu_1, \mu_4), \quad \bar d_2 = d_1 \bar R_2/R_1, \quad \bar d_3 = d_4 \bar R_3/R_4

with effective radii, :math:`\mu_2 = \mu_3 \le \mu_1 \le \mu_4` and :math:`\bar d_1` what is left of the whole. x is counted
from the bearing's centre, and F is its horizontal force. Friction that changes with velocity, heat or load, uplift and motion
in two directions are not in it: use OpenSees' TripleFrictionPendulum for these.

Take the numbers from the maker's sheet and fit few of them (``fixed=``). A search for all ten from one point ends in places
that are not the bearing's, so a fit has ten starts unless it is told otherwise (``starts=``), and still may: look at its L1.
A stop that no record reaches is not known. A `compliance` beside it is a greater uy. A step is exact, however long: the force
is the root of a law of straight pieces that rises. It dissipates whatever the motion: springs, sliders and stops make it up.

Fenz and Constantinou (2008), Earthquake Engineering and Structural Dynamics 37, 163 and 185; Dao, Ryan, Sato and Sasaki (2013),
Earthquake Engineering and Structural Dynamics 42, 1677.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import Annotated

from dampyr.errors import InputError
from dampyr.models.codegen.formula import intrinsic
from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.units import Quantity

HOLDS = ("spring", "compliance")
STATES = {"u1": (-inf, inf), "u2": (-inf, inf), "u3": (-inf, inf)}
WITHIN_STROKE = ("u1", "u2", "u3")
SEARCH_STARTS = 10
NOT_TRIED = "it is a bearing's, whose numbers its maker states"
MAX_ROUNDS = 200  # halving the bracket alone needs about 60; its pieces are thirteen at most
CLOSE = 1e-15  # of the bracket's first width
EXAMPLE = {
    "f1": 150.0,
    "r2": 2.0,
    "r3": 3.0,
    "l1": 0.002,
    "l2": 0.006,
    "l3": 0.006,
    "d1": 0.001,
    "d2": 0.004,
    "d3": 0.1,
    "uy": 5e-5,
}


@checked
@dataclass(frozen=True)
class TriplePendulum:
    """Friction ``f1``, ``r2``, ``r3`` over it; ``l1`` to ``l3``; stops ``d1`` to ``d3``; the elastic ``uy``."""

    f1: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    r2: Annotated[float, Quantity("", low=0, open_low=True)]
    r3: Annotated[float, Quantity("", low=0, open_low=True)]
    l1: Annotated[float, Quantity("m", low=0, open_low=True)]
    l2: Annotated[float, Quantity("m", low=0, open_low=True)]
    l3: Annotated[float, Quantity("m", low=0, open_low=True)]
    d1: Annotated[float, Quantity("m", low=0, open_low=True)]
    d2: Annotated[float, Quantity("m", low=0, open_low=True)]
    d3: Annotated[float, Quantity("m", low=0, open_low=True)]
    uy: Annotated[float, Quantity("m", low=0, open_low=True)]


@intrinsic()
def pendulum_slides(u: float, f: float, r: float, ell: float, d: float) -> float:
    """How much a slider moves with the force: 0 where it sticks or is at its stop."""
    moved = min(max(u, ell * (f - r)), ell * (f + r))
    if moved == u:
        return 0.0
    if abs(moved) >= d:
        return 0.0
    return ell


@intrinsic()
def pendulum_place(u: float, f: float, r: float, ell: float, d: float) -> float:
    """Where a slider is under the force f, from u."""
    return min(max(min(max(u, ell * (f - r)), ell * (f + r)), -d), d)


@intrinsic()
def pendulum_force(
    u1: float, u2: float, u3: float, x: float, r2: float, r3: float, l1: float, l2: float, l3: float,
    d1: float, d2: float, d3: float, uy: float,
) -> float:  # fmt: skip
    """The force over f1 at x: Newton's method in a bracket; constant as far as derivatives go, a last step has them."""
    most = max(d1, abs(u1)) + max(d2, abs(u2)) + max(d3, abs(u3))
    low = (x - most) / uy
    high = (x + most) / uy
    wide = high - low
    f = (x - u1 - u2 - u3) / uy
    for _ in range(MAX_ROUNDS):
        stretch = (
            pendulum_place(u1, f, 1.0, l1, d1) + pendulum_place(u2, f, r2, l2, d2) + pendulum_place(u3, f, r3, l3, d3)
        )
        excess = uy * f + stretch - x
        if excess > 0.0:
            high = f
        else:
            low = f
        if excess == 0.0 or high - low <= CLOSE * wide:
            break
        slope = uy + pendulum_slides(u1, f, 1.0, l1, d1) + pendulum_slides(u2, f, r2, l2, d2)
        slope = slope + pendulum_slides(u3, f, r3, l3, d3)
        step = excess / slope
        f = f - step
        if abs(step) <= CLOSE * abs(f):
            break
        if f <= low or f >= high:
            f = 0.5 * (low + high)
    return f


def advance(
    u1: float, u2: float, u3: float, x1: float, r2: float, r3: float, l1: float, l2: float, l3: float,
    d1: float, d2: float, d3: float, uy: float,
) -> tuple[float, float, float]:  # fmt: skip
    f = pendulum_force(u1, u2, u3, x1, r2, r3, l1, l2, l3, d1, d2, d3, uy)
    slope = (
        uy
        + pendulum_slides(u1, f, 1.0, l1, d1)
        + pendulum_slides(u2, f, r2, l2, d2)
        + pendulum_slides(u3, f, r3, l3, d3)
    )
    e1 = d1 * slip(l1 * (f + slip((u1 - l1 * f) / l1, 0.0)) / d1, 0.0)
    e2 = d2 * slip(l2 * (f + r2 * slip((u2 - l2 * f) / (l2 * r2), 0.0)) / d2, 0.0)
    e3 = d3 * slip(l3 * (f + r3 * slip((u3 - l3 * f) / (l3 * r3), 0.0)) / d3, 0.0)
    f = f - (uy * f + e1 + e2 + e3 - x1) / slope
    e1 = d1 * slip(l1 * (f + slip((u1 - l1 * f) / l1, 0.0)) / d1, 0.0)
    e2 = d2 * slip(l2 * (f + r2 * slip((u2 - l2 * f) / (l2 * r2), 0.0)) / d2, 0.0)
    e3 = d3 * slip(l3 * (f + r3 * slip((u3 - l3 * f) / (l3 * r3), 0.0)) / d3, 0.0)
    return e1, e2, e3


def force(u1: float, u2: float, u3: float, x: float, f1: float, uy: float) -> float:
    return f1 * (x - u1 - u2 - u3) / uy


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for soft in (1.0, 4.0):
        for friction in (2.0, 5.0):
            yield {
                "r2": friction, "r3": 2.0 * friction, "l1": 0.1 * soft * scale.stroke, "l2": 0.2 * soft * scale.stroke,
                "l3": 0.2 * soft * scale.stroke, "d1": 0.2 * scale.stroke, "d2": scale.stroke, "d3": scale.stroke,
                "uy": 0.003 * scale.stroke,
            }  # fmt: skip


def from_bearing(
    W: float, mu: tuple[float, float, float, float], R: tuple[float, float, float, float],
    d: tuple[float, float, float, float], uy: float,
) -> TriplePendulum:  # fmt: skip
    """The bearing of four surfaces from below: load [N], friction, effective radii [m], displacements to the stops [m], uy [m].

    Raises :class:`~dampyr.errors.InputError` where the inner surfaces are not alike, or slide after the outer ones.
    """
    if W <= 0 or mu[1] != mu[2] or not 0 < mu[1] <= mu[0] <= mu[3] or min(R[0] - R[1], R[3] - R[2]) <= 0:
        raise InputError(
            f"W = {W:g} N, mu = {mu} and R = {R} m; W must be greater than 0, mu[1] = mu[2] <= mu[0] <= mu[3] "
            "(turn the bearing over), and the outer radii greater than the inner ones"
        )
    f1, r = mu[1] * W, (R[1] + R[2], R[0] - R[1], R[3] - R[2])
    d2, d3 = d[0] * r[1] / R[0], d[3] * r[2] / R[3]
    l1, l2, l3 = (mu[1] * radius for radius in r)
    return TriplePendulum(
        f1=f1, r2=mu[0] / mu[1], r3=mu[3] / mu[1], l1=l1, l2=l2, l3=l3, d1=sum(d) - d2 - d3, d2=d2, d3=d3, uy=uy
    )
