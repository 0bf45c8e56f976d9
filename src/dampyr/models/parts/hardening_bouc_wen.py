r"""The Bouc-Wen model that is not normalised, whose loops may harden: `bouc_wen` past its limit.

.. math:: F = c_0 v + k_0 x + k_w w, \qquad \dot w = \rho\left(v + (1 + h)\,v\,|w|^n - |v|\,|w|^{n-1} w\right)

Along the way away from w = 0 its slope over :math:`\rho x` is :math:`1 + h |w|^n`, back towards it :math:`1 + (2 + h) |w|^n`.
The state is :math:`z = w/\rho`, in m; a fit takes it to begin within the stroke of its records. With h > 0 a loop hardens, as
those of wire ropes and rubber do; at h = 0 its flank is straight, and with h from -1 to 0 it is `bouc_wen` with
:math:`\sigma = -1/h`, whose w approaches its limit, here :math:`(-h)^{-1/n}`. For :math:`\sigma < 1` use `bouc_wen`.

The letters of (2.2) of Raminelli (2020), :math:`\dot z = A v - \gamma |v| |z|^{n-1} z - \beta v |z|^n` with
:math:`\alpha z` in the force, say too much: z can be scaled at will. Here :math:`w = z\,(\gamma/A)^{1/n}`, so that
:math:`h = -(\beta+\gamma)/\gamma`, :math:`\rho = A\,(\gamma/A)^{1/n}` and :math:`k_w = \alpha\,(A/\gamma)^{1/n}`.
`from_printed` and `to_printed` convert them, and refuse A or gamma of 0 and below (the loop makes energy) and beta > 0.

What is known of its stability. It dissipates whatever the motion, with c0 and k0 of 0 and more: with
:math:`S(w) = \frac{k_w}{\rho} \int_0^{|w|} \frac{u\,du}{1 + (2+h) u^n}` stored, the work :math:`k_w w\,dx` is dS on the way
back and more than dS on the way out. It is in none of the classes of Ikhouane and Rodellar (2007) where h >= 0, as no limit
holds for every motion. One holds for every stroke: from w = 0, with x within the width X, :math:`|w|` is at most that after
one way of X, :math:`\int_0^{|w|} du/(1 + h u^n) \le \rho X`. For n > 1 and h > 0 that is infinite where X reaches
:math:`\frac{1}{\rho}\,\frac{\pi/n}{\sin(\pi/n)}\,h^{-1/n}`, the number that `longest_way` gives. So do not use it beyond the
strokes that it was identified on. A path on which w becomes infinite is refused by `Damper.force` with its time; a search
drops such numbers, a response says that it grows without bound, and an exported damper gives a force that is infinite.

The step along a monotone path is exact for every n (`dampyr.models.numerics.bouc_wen_two_sided`). In records whose w stays
small, h and n are known together only; records of one amplitude tell kw and rho from k0 by the bend alone.

Bouc (1971); Wen (1976); the classes: Ikhouane and Rodellar (2007), Systems with Hysteresis.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, inf, pi, sin
from typing import Annotated

from dampyr.errors import InputError
from dampyr.models.numerics.bouc_wen_two_sided import two_sided_flow
from dampyr.models.part import Scale, checked
from dampyr.models.parts.bouc_wen import MAX_EXPONENT, PrintedBoucWen
from dampyr.units import Quantity

HOLDS = ("spring",)
STATES = {"z": (-inf, inf)}
WITHIN_STROKE = ("z",)
UNBOUNDED = "its loops harden and w is infinite after a path that is too long (longest_way of its file)"
NOT_TRIED = "a hardening loop that fits the strokes of its records may have no limit beyond them"
MAX_HARDENING = 1000.0  # of h: where w is 0.1 and n = 2, the slope is eleven times the first
EXAMPLE = {"c0": 200.0, "k0": 0.0, "kw": 150.0, "rho": 150.0, "h": 0.3, "n": 1.2}


@checked
@dataclass(frozen=True)
class HardeningBoucWen:
    """Dashpot ``c0``, spring ``k0``, hysteretic force ``kw``, ``rho``, the hardening ``h`` and the exponent ``n``."""

    c0: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    k0: Annotated[float, Quantity("N/m", linear=True)]
    kw: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]
    h: Annotated[float, Quantity("", low=-1, high=MAX_HARDENING)]
    n: Annotated[float, Quantity("", low=1, high=MAX_EXPONENT)]


def advance(z: float, x0: float, x1: float, rho: float, h: float, n: float) -> float:
    s = copysign(1.0, x1 - x0)
    return s * two_sided_flow(s * rho * z, rho * abs(x1 - x0), n, h, 2.0 + h) / rho


def rates(z: float, v: float, rho: float, h: float, n: float) -> float:
    y = abs(rho * z) ** n
    return v + (1.0 + h) * v * y - abs(v) * copysign(y, z)


def switches(v: float) -> float:
    return v


def force(z: float, x: float, v: float, c0: float, k0: float, kw: float, rho: float) -> float:
    return c0 * v + k0 * x + kw * rho * z


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (2.0, 0.5, 0.1):
        for n in (1.2, 2.0):
            for h in (0.3, -0.5):
                yield {"rho": 1.0 / (path * scale.stroke), "h": h, "n": n}


def longest_way(model: HardeningBoucWen) -> float:
    """The way in one direction, in m, after which w is infinite from 0; infinite where no way is that long."""
    if model.h <= 0.0 or model.n == 1.0:
        return inf
    return pi / model.n / sin(pi / model.n) * model.h ** (-1.0 / model.n) / model.rho


def from_printed(c0: float, k0: float, alpha: float, A: float, beta: float, gamma: float, n: float) -> HardeningBoucWen:
    r"""The model with a printed set of numbers, ``gamma`` with \|v\| and ``beta`` with v as in (2.2); SI units.

    Raises :class:`~dampyr.errors.InputError` where A, alpha or gamma is not greater than 0, or beta is.
    """
    if A <= 0 or alpha <= 0 or gamma <= 0 or beta > 0:
        raise InputError(
            f"A = {A:g}, alpha = {alpha:g}, gamma = {gamma:g} and beta = {beta:g}; the first three must be greater than 0 "
            "(else the loop makes energy), and beta at most 0: a set with a greater one is that of bouc_wen"
        )
    scale = (A / gamma) ** (1.0 / n)
    return HardeningBoucWen(c0=c0, k0=k0, kw=alpha * scale, rho=A / scale, h=-(beta + gamma) / gamma, n=n)


def to_printed(model: HardeningBoucWen, A: float = 1.0) -> PrintedBoucWen:
    """The printed letters, with the free scale of z fixed by ``A``."""
    if A <= 0:
        raise InputError(f"A = {A:g} is not allowed; the scale of z must be greater than 0")
    scale = A / model.rho
    gamma = A / scale**model.n
    return PrintedBoucWen(
        c0=model.c0, k0=model.k0, alpha=model.kw / scale, A=A, beta=-(1.0 + model.h) * gamma, gamma=gamma, n=model.n
    )  # fmt: skip
