r"""The generalised Bouc-Wen model of Song and Der Kiureghian: loops that differ by the signs of place, velocity and memory.

.. math:: F = c_0 v + k_0 x + k_w w, \qquad \dot w = \rho\,v\left(1 - |w|^n \psi\right)

.. math:: \psi = \operatorname{sgn}(v w) + b_2 \operatorname{sgn}(x v) + b_3 \operatorname{sgn}(x w) + b_4 \operatorname{sgn} v
          + b_5 \operatorname{sgn} w + b_6 \operatorname{sgn} x

of devices that pull otherwise than they push, and leave the middle otherwise than they come back. The source has
:math:`\dot z = v (A - |z|^n \psi)` with :math:`\beta_1` to :math:`\beta_6`, in which the scale of z is free: here
:math:`w = z\,(\beta_1/A)^{1/n}` and :math:`b_i = \beta_i/\beta_1`, so :math:`\beta_1` and A must be greater than 0;
`from_printed` converts them. With b2 to b6 of 0 it is `hardening_bouc_wen` with h = -1, and `bouc_wen` with
:math:`\sigma = 1`. x is counted from 0 of the record, which must be where the device changes over. The state is
:math:`z = w/\rho`, in m, and a fit takes it to begin within the stroke of its records.

On the way out of w = 0 in the direction s the slope over :math:`\rho x` is :math:`1 - \psi_o |w|^n`, on the way back
:math:`1 + \psi_b |w|^n`, with

.. math:: \psi_o = 1 + (b_2 + b_3)\,s \operatorname{sgn} x + (b_4 + b_5)\,s + b_6 \operatorname{sgn} x, \qquad
          \psi_b = 1 - (b_2 - b_3)\,s \operatorname{sgn} x - (b_4 - b_5)\,s - b_6 \operatorname{sgn} x

It is bounded for every motion where :math:`|b_2 + b_3 + b_6| < 1 + b_4 + b_5` and :math:`|b_2 + b_3 - b_6| < 1 - b_4 - b_5`;
else it may harden without a limit, as `hardening_bouc_wen` does, and a path on which w becomes infinite is refused. It
dissipates whatever the motion where besides :math:`|b_2| + |b_4| \le 1`, :math:`|b_3 + b_6| \le 1 + b_4` and
:math:`|b_3 - b_6| \le 1 - b_4`: what is stored at w is then what the softest way back gives, and every way out costs more.
Where these do not hold a loop may make energy. `describe_limits` says which of them a model breaks; a fit does not keep to
them, so ask it before a building has the damper.

The step along a monotone path, which is cut where x is 0, is exact for every n (`dampyr.models.numerics.bouc_wen_two_sided`).

Song and Der Kiureghian (2006), Journal of Engineering Mechanics 132, 610; the equation and the order of the six terms as in
one public implementation that cites it, not checked against the article itself.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, inf
from typing import Annotated

from dampyr.errors import InputError
from dampyr.models.numerics.bouc_wen_two_sided import two_sided_flow
from dampyr.models.part import Scale, checked
from dampyr.models.parts.bouc_wen import MAX_EXPONENT
from dampyr.units import Quantity

HOLDS = ("spring",)
STATES = {"z": (-inf, inf)}
WITHIN_STROKE = ("z",)
UNBOUNDED = "it is not bounded with these numbers (describe_limits of its file)"
NOT_TRIED = "its five numbers of asymmetry take records that tell them apart, and may make energy"
MOST = 4.0  # of a number beside the first one, which is 1
EXAMPLE = {
    "c0": 0.0,
    "k0": 5e3,
    "kw": 350.0,
    "rho": 600.0,
    "n": 1.5,
    "b2": -0.2,
    "b3": 0.0,
    "b4": 0.3,
    "b5": 0.1,
    "b6": 0.0,
}


@checked
@dataclass(frozen=True)
class AsymmetricBoucWen:
    """Dashpot ``c0``, spring ``k0``, hysteretic force ``kw``, ``rho``, exponent ``n``, and ``b2`` to ``b6`` over the first."""

    c0: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    k0: Annotated[float, Quantity("N/m", linear=True)]
    kw: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]
    n: Annotated[float, Quantity("", low=1, high=MAX_EXPONENT)]
    b2: Annotated[float, Quantity("", low=-MOST, high=MOST)]
    b3: Annotated[float, Quantity("", low=-MOST, high=MOST)]
    b4: Annotated[float, Quantity("", low=-MOST, high=MOST)]
    b5: Annotated[float, Quantity("", low=-MOST, high=MOST)]
    b6: Annotated[float, Quantity("", low=-MOST, high=MOST)]


def advance(
    z: float, x0: float, x1: float, rho: float, n: float, b2: float, b3: float, b4: float, b5: float, b6: float
) -> float:
    s = copysign(1.0, x1 - x0)
    side = copysign(1.0, x0 + x1)
    middle = x1
    if x0 * x1 < 0.0:
        side = copysign(1.0, x0)
        middle = 0.0
    out = -1.0 - (b2 + b3) * s * side - (b4 + b5) * s - b6 * side
    back = 1.0 - (b2 - b3) * s * side - (b4 - b5) * s - b6 * side
    y = two_sided_flow(s * rho * z, rho * abs(middle - x0), n, out, back)
    if x0 * x1 < 0.0:
        out = -1.0 + (b2 + b3) * s * side - (b4 + b5) * s + b6 * side
        back = 1.0 + (b2 - b3) * s * side - (b4 - b5) * s + b6 * side
        y = two_sided_flow(y, rho * abs(x1), n, out, back)
    return s * y / rho


def rates(
    z: float, x: float, v: float, rho: float, n: float, b2: float, b3: float, b4: float, b5: float, b6: float
) -> float:
    s = copysign(1.0, v)
    side = copysign(1.0, x)
    r = copysign(1.0, z)
    psi = s * r + b2 * side * s + b3 * side * r + b4 * s + b5 * r + b6 * side
    return v * (1.0 - abs(rho * z) ** n * psi)


def switches(x: float, v: float) -> tuple[float, float]:
    return x, v


def force(z: float, x: float, v: float, c0: float, k0: float, kw: float, rho: float) -> float:
    return c0 * v + k0 * x + kw * rho * z


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (0.5, 0.15, 0.04):
        for n in (1.05, 2.0):
            yield {"rho": 1.0 / (path * scale.stroke), "n": n, "b2": 0.0, "b3": 0.0, "b4": 0.0, "b5": 0.0, "b6": 0.0}


def describe_limits(model: AsymmetricBoucWen) -> list[str]:
    """What the numbers of a model do not keep to: none of it where the model is bounded and dissipates whatever the motion."""
    b2, b3, b4, b5, b6 = model.b2, model.b3, model.b4, model.b5, model.b6
    bounded = {
        "|b2 + b3 + b6| < 1 + b4 + b5": abs(b2 + b3 + b6) < 1.0 + b4 + b5,
        "|b2 + b3 - b6| < 1 - b4 - b5": abs(b2 + b3 - b6) < 1.0 - b4 - b5,
    }
    dissipative = {
        "|b2| + |b4| <= 1": abs(b2) + abs(b4) <= 1.0,
        "|b3 + b6| <= 1 + b4": abs(b3 + b6) <= 1.0 + b4,
        "|b3 - b6| <= 1 - b4": abs(b3 - b6) <= 1.0 - b4,
    }
    return [
        *(f"it is not bounded for every motion: {rule} does not hold" for rule, holds in bounded.items() if not holds),
        *(f"a loop may make energy: {rule} does not hold" for rule, holds in dissipative.items() if not holds),
    ]


def from_printed(
    c0: float, k0: float, alpha: float, A: float, n: float, betas: tuple[float, float, float, float, float, float]
) -> AsymmetricBoucWen:
    """The model with the letters of the source, and ``alpha`` z in the force; SI units.

    Raises :class:`~dampyr.errors.InputError` where A, alpha or the first of ``betas`` is not greater than 0.
    """
    first, *others = betas
    if A <= 0 or alpha <= 0 or first <= 0:
        raise InputError(f"A = {A:g}, alpha = {alpha:g} and beta_1 = {first:g}; each must be greater than 0")
    scale = (A / first) ** (1.0 / n)
    b2, b3, b4, b5, b6 = (beta / first for beta in others)
    return AsymmetricBoucWen(
        c0=c0, k0=k0, kw=alpha * scale, rho=A / scale, n=n, b2=b2, b3=b3, b4=b4, b5=b5, b6=b6
    )  # fmt: skip
