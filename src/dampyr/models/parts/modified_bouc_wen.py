r"""The modified Bouc-Wen model: a Bouc-Wen element in series with a dashpot, beside a spring.

.. math:: F = c_1 \dot y + k_1 x, \qquad c_1 \dot y = k_w w + k_0 (x - y) + c_0 (\dot x - \dot y)

.. math:: \dot w = \rho\left(u - \sigma |u|\,|w|^{n-1} w + (\sigma - 1) u |w|^n\right), \qquad u = \dot x - \dot y

y is the node between the two; the dashpot c1 in series rolls the force off where the velocity is small and changes its sign.
The shape is set by ratios, so that the force is proportional to kw and k1: :math:`v_c = k_w/c_1` is the speed at which
the dashpot in series carries kw, :math:`r = c_0/c_1`, :math:`\kappa = k_0/k_w`. The states are w in [-1, 1] and the elongation
e = x - y of the element in m. The letters of the source are converted by `from_printed` and `to_printed`; its x0 is the
`offset`.

A step takes e by the trapezoidal rule, with the mean of w along its own exact path
(`dampyr.models.numerics.bouc_wen_exact`): implicit, stable at any step, of second order. Where e turns round inside a
step, what it travels beyond both ends is left out, as with any path through samples: with the source's numbers (rho near
50/mm, 15 mm at 2.5 Hz) the error is 0.6 % of the peak force (rms) at 200 samples per second and 0.06 % at 1000. With vc
-> 0 the model is `bouc_wen`, with the dashpot c0 = kw r/vc and a spring of which only the sum k1 + kw kappa is seen.

A fit takes e at the start of a record to be within the stroke of all its records.

Spencer, Dyke, Sain and Carlson (1997), Journal of Engineering Mechanics 123, 230.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, inf
from typing import Annotated

from dampyr.errors import InputError
from dampyr.models.numerics.bouc_wen_exact import flow
from dampyr.models.part import Scale, checked
from dampyr.models.parts import bouc_wen
from dampyr.models.parts._series import extension, held_rate, slope
from dampyr.units import Quantity

HOLDS = ("spring",)
STATES = {"w": (-1.0, 1.0), "e": (-inf, inf)}
# A record shows little more than the product of kappa and the elongation that it begins with. Without a limit a fit follows it
# to an elongation of any size and no spring.
WITHIN_STROKE = ("e",)
EXAMPLE = {"kw": 350.0, "k1": 5e3, "vc": 0.05, "r": 0.3, "kappa": 20.0, "rho": 800.0, "sigma": 1.0, "n": 2.0}


@checked
@dataclass(frozen=True)
class ModifiedBoucWen:
    """Hysteretic force ``kw``, spring ``k1``, ``vc`` = kw/c1, ``r`` = c0/c1, ``kappa`` = k0/kw, and the shape."""

    kw: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    k1: Annotated[float, Quantity("N/m", linear=True)]
    vc: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    # Where vc is small only r/vc is seen, which is c0/kw: a straight line between logarithms.
    r: Annotated[float, Quantity("", low=0, logarithmic=True)]
    kappa: Annotated[float, Quantity("1/m", low=0)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]
    sigma: Annotated[float, Quantity("", low=0, high=bouc_wen.MAX_SIGMA, open_low=True)]
    n: Annotated[float, Quantity("", low=1, high=bouc_wen.MAX_EXPONENT)]


def advance(
    w: float,
    e: float,
    x0: float,
    x1: float,
    dt: float,
    vc: float,
    r: float,
    kappa: float,
    rho: float,
    sigma: float,
    n: float,
) -> tuple[float, float]:
    gain = rho / (1.0 + r + 0.5 * vc * kappa * dt)
    pull = gain * (x1 - x0 - vc * dt * (w + kappa * e))
    s = copysign(1.0, pull)
    c = 2.0 * sigma - 1.0
    y = s * w
    beta = gain * vc * dt
    near = extension(y, abs(pull), beta, n, c)
    half = flow(y, 0.5 * near, n, c)
    end = flow(y, near, n, c)
    excess = near + beta * ((y + 4.0 * half + end) / 6.0 - y) - abs(pull)
    xi = near - excess / slope(half, end, beta, n, c)
    return s * (end + held_rate(end, n, c) * (xi - near)), e + s * xi / rho


def rates(
    w: float, e: float, v: float, vc: float, r: float, kappa: float, rho: float, sigma: float, n: float
) -> tuple[float, float]:
    u = (v - vc * (w + kappa * e)) / (1.0 + r)
    h = abs(w) ** n
    return rho * (u - sigma * abs(u) * copysign(h, w) + (sigma - 1.0) * u * h), u


def switches(w: float, e: float, v: float, vc: float, kappa: float) -> float:
    return v - vc * (w + kappa * e)


def force(w: float, e: float, x: float, v: float, kw: float, k1: float, vc: float, r: float, kappa: float) -> float:
    return kw * (w + kappa * e + r * v / vc) / (1.0 + r) + k1 * x


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (0.1, 0.02):
        for speed in (0.3, 0.05):
            for n in (1.05, 2.0):
                yield {
                    "vc": speed * scale.speed,
                    "r": 0.1,
                    "kappa": 0.1 / scale.stroke,
                    "rho": 1.0 / (path * scale.stroke),
                    "sigma": 1.0,
                    "n": n,
                }


@dataclass(frozen=True)
class PrintedModifiedBoucWen:
    r"""The letters of the source, whose state is z.

    .. math:: \dot z = -\gamma|\dot x - \dot y| z |z|^{n-1} - \beta(\dot x - \dot y)|z|^n + A(\dot x - \dot y)
    """

    c0: float
    c1: float
    k0: float
    k1: float
    alpha: float
    A: float
    beta: float
    gamma: float
    n: float


def from_printed(printed: PrintedModifiedBoucWen) -> ModifiedBoucWen:
    """The part with the source's letters, in SI units; :class:`~dampyr.errors.InputError` for what it cannot have."""
    p = printed
    if p.c1 <= 0:
        raise InputError(f"c1 = {p.c1:g} N s/m is not allowed; the dashpot in series must be greater than 0")
    inner = bouc_wen.from_printed(p.c0, p.k0, p.alpha, p.A, p.beta, p.gamma, p.n)
    return ModifiedBoucWen(
        kw=inner.kw,
        k1=p.k1,
        vc=inner.kw / p.c1,
        r=p.c0 / p.c1,
        kappa=p.k0 / inner.kw,
        rho=inner.rho,
        sigma=inner.sigma,
        n=p.n,
    )


def to_printed(model: ModifiedBoucWen, A: float = 1.0) -> PrintedModifiedBoucWen:
    """The source's letters of a part, with the free scale of z fixed by ``A``."""
    c1 = model.kw / model.vc
    element = bouc_wen.BoucWen(model.r * c1, model.kappa * model.kw, model.kw, model.rho, model.sigma, model.n)
    inner = bouc_wen.to_printed(element, A)
    return PrintedModifiedBoucWen(
        inner.c0, c1, inner.k0, model.k1, inner.alpha, inner.A, inner.beta, inner.gamma, inner.n
    )
