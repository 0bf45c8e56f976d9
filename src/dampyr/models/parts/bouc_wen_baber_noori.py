r"""The Bouc-Wen-Baber-Noori model: loops of `bouc_wen` that pinch and degrade with the energy they have taken.

.. math:: F = k_0 x + k_w w, \qquad
          \dot w = \rho\,\frac{h}{\eta}\left(v - \nu\left(\sigma |v|\,|w|^{n-1} w - (\sigma - 1) v |w|^n\right)\right),
          \qquad \dot\varepsilon = w v

.. math:: h = 1 - \zeta_1 \exp\left(-\frac{(w \operatorname{sgn} v - q\,\nu^{-1/n})^2}{\zeta_2^2}\right), \quad
          \zeta_1 = \zeta_s (1 - e^{-p \varepsilon}), \quad
          \zeta_2 = (\psi + \delta_\psi \varepsilon)(\lambda + \zeta_1), \quad
          \nu = 1 + \delta_\nu \varepsilon, \quad \eta = 1 + \delta_\eta \varepsilon

of reinforced concrete, timber joints and other devices that wear: h pinches the loop near the share q of its limit, nu lowers
the strength and eta the stiffness. :math:`\varepsilon` is the energy of the hysteresis over kw, in m. The letters are those of
OpenSees' BWBN (zetas, q, p, Shi = psi, deltaShi, lamda), made free of the scale of its z: `from_opensees` converts them; its
BWBN has no nu and eta. With zetas, deltanu and deltaeta 0 it is `bouc_wen` with c0 = 0; a dashpot beside it is `power_law`
with alpha = 1.

A record begins with a device as new: both states are 0 there and are not fitted, so records are first tests of specimens
that are alike, and a card is of the new device. Several of its eleven shape numbers do nearly the same, so hold those that are
known (``fixed=``), and trust a fit no further than its intervals.

A step takes h, nu and eta at its middle, as a half step finds it, and the exact step of `bouc_wen` with them: of second order,
exact without pinching and degradation, and w stays within its limit however long the step. It dissipates by construction only
without them, as `bouc_wen` does: stiffness and pinching change within a loop.

Foliente (1995), Journal of Structural Engineering 121, 1013; Baber and Noori (1986), Journal of Vibration, Acoustics, Stress
and Reliability in Design 108, 411; OpenSees' BWBN.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, exp, inf, log
from typing import Annotated

from dampyr.errors import InputError
from dampyr.models.part import Scale, checked
from dampyr.models.parts import bouc_wen
from dampyr.models.parts._falling_limit import falling_flow
from dampyr.units import Quantity

HOLDS = ("spring",)
RISES_IN_SERIES = True  # where a long step ends in the pinch that its middle has found
STARTS_AT_REST = True
STATES = {"w": (-1.0, 1.0), "e": (-inf, inf)}
EXAMPLE = {
    "k0": 5e3,
    "kw": 350.0,
    "rho": 800.0,
    "sigma": 0.7,
    "n": 1.5,
    "zetas": 0.95,
    "q": 0.1,
    "p": 400.0,
    "Shi": 0.3,
    "deltaShi": 2.0,
    "lamda": 0.3,
    "deltanu": 1.0,
    "deltaeta": 1.0,
}


@checked
@dataclass(frozen=True)
class BoucWenBaberNoori:
    """Spring ``k0``, hysteresis ``kw``, ``rho``, ``sigma``, ``n``, and the six and two numbers of pinching and degradation."""

    k0: Annotated[float, Quantity("N/m", linear=True)]
    kw: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]
    sigma: Annotated[float, Quantity("", low=0, high=bouc_wen.MAX_SIGMA, open_low=True)]
    n: Annotated[float, Quantity("", low=1, high=bouc_wen.MAX_EXPONENT)]
    zetas: Annotated[float, Quantity("", low=0, high=0.999)]
    q: Annotated[float, Quantity("", low=0, high=1)]
    p: Annotated[float, Quantity("1/m", low=0)]
    Shi: Annotated[float, Quantity("", low=0, open_low=True)]
    deltaShi: Annotated[float, Quantity("1/m", low=0)]
    lamda: Annotated[float, Quantity("", low=0, open_low=True)]
    deltanu: Annotated[float, Quantity("1/m", low=0)]
    deltaeta: Annotated[float, Quantity("1/m", low=0)]


def advance(
    w: float, e: float, x0: float, x1: float, rho: float, sigma: float, n: float, zetas: float, q: float, p: float,
    Shi: float, deltaShi: float, lamda: float, deltanu: float, deltaeta: float,
) -> tuple[float, float]:  # fmt: skip
    s = copysign(1.0, x1 - x0)
    path = rho * abs(x1 - x0)
    c = 2.0 * sigma - 1.0
    worn = abs(e)  # never less than 0 from rest, but for rounding
    wide = exp(log(1.0 + deltanu * worn) / n)
    taken = zetas * (1.0 - exp(-p * worn))
    spread = (Shi + deltaShi * worn) * (lamda + taken)
    h = 1.0 - taken * exp(-(((s * w - q / wide) / spread) ** 2))
    half = s * falling_flow(s * w * wide, 0.5 * path * wide * h / (1.0 + deltaeta * worn), n, c) / wide
    worn = abs(e + 0.25 * (x1 - x0) * (w + half))
    wide = exp(log(1.0 + deltanu * worn) / n)
    taken = zetas * (1.0 - exp(-p * worn))
    spread = (Shi + deltaShi * worn) * (lamda + taken)
    h = 1.0 - taken * exp(-(((s * half - q / wide) / spread) ** 2))
    end = s * falling_flow(s * w * wide, path * wide * h / (1.0 + deltaeta * worn), n, c) / wide
    return end, e + (x1 - x0) * (w + 4.0 * half + end) / 6.0


def rates(
    w: float, e: float, v: float, rho: float, sigma: float, n: float, zetas: float, q: float, p: float,
    Shi: float, deltaShi: float, lamda: float, deltanu: float, deltaeta: float,
) -> tuple[float, float]:  # fmt: skip
    worn = abs(e)
    nu = 1.0 + deltanu * worn
    taken = zetas * (1.0 - exp(-p * worn))
    spread = (Shi + deltaShi * worn) * (lamda + taken)
    h = 1.0 - taken * exp(-(((w * copysign(1.0, v) - q * exp(-log(nu) / n)) / spread) ** 2))
    y = nu * abs(w) ** n
    slope = rho * h / (1.0 + deltaeta * worn)
    return slope * (v - sigma * abs(v) * copysign(y, w) + (sigma - 1.0) * v * y), w * v


def switches(v: float) -> float:
    return v


def force(w: float, x: float, k0: float, kw: float) -> float:
    return k0 * x + kw * w


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (0.3, 0.1, 0.03):
        for n in (1.05, 2.0):
            for zetas in (0.05, 0.7):
                taken = 3.0 / scale.stroke
                yield {
                    "rho": 1.0 / (path * scale.stroke), "sigma": 0.7, "n": n, "zetas": zetas, "q": 0.1, "p": taken,
                    "Shi": 0.4, "deltaShi": 0.01 * taken, "lamda": 0.3, "deltanu": 0.01 * taken, "deltaeta": 0.01 * taken,
                }  # fmt: skip


def from_opensees(
    alpha: float, ko: float, n: float, gamma: float, beta: float, Ao: float,
    q: float, zetas: float, p: float, Shi: float, deltaShi: float, lamda: float,
) -> BoucWenBaberNoori:  # fmt: skip
    r"""The model with the numbers of OpenSees' ``uniaxialMaterial('BWBN', ...)`` in N and m, in its order.

    .. math:: z_\max = (A_o/(\beta+\gamma))^{1/n}, \quad k_w = (1-\alpha) k_o z_\max, \quad \rho = A_o/z_\max, \quad
              \sigma = \beta/(\beta+\gamma)

    There beta multiplies \|v\| z and gamma v \|z\|^n. Raises :class:`~dampyr.errors.InputError` where z has no limit.
    """
    if Ao <= 0 or beta + gamma <= 0 or beta <= 0 or not 0 <= alpha < 1:
        raise InputError(
            f"Ao = {Ao:g}, beta + gamma = {beta + gamma:g}, beta = {beta:g} and alpha = {alpha:g}; the first three must be "
            "greater than 0, and alpha at least 0 and below 1"
        )
    z_max = (Ao / (beta + gamma)) ** (1.0 / n)
    kw = (1.0 - alpha) * ko * z_max
    return BoucWenBaberNoori(
        k0=alpha * ko, kw=kw, rho=Ao / z_max, sigma=beta / (beta + gamma), n=n, zetas=zetas, q=q * Ao ** (-1.0 / n),
        p=p * kw, Shi=Shi / z_max, deltaShi=deltaShi * kw / z_max, lamda=lamda, deltanu=0.0, deltaeta=0.0,
    )  # fmt: skip
