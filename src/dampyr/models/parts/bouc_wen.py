r"""The Bouc-Wen model: spring, dashpot and hysteresis, in the normalised letters.

.. math:: F = c_0 v + k_0 x + k_w w, \qquad
          \dot w = \rho\left(v - \sigma |v|\,|w|^{n-1} w + (\sigma - 1) v |w|^n\right)

w stays in [-1, 1]. The usual seven letters are singular, because z can be scaled at will; these six are not. With n = 1 and
sigma = 1 the model is `dahl` with a spring. It dissipates whatever the motion, for every sigma > 0: with
:math:`S(w) = \frac{k_w}{\rho} \int_0^{|w|} \frac{u\,du}{1 + (2\sigma - 1) u^n}` stored, the work :math:`k_w w\,dx` is dS on
the way back towards w = 0 and more than dS on the way out. At sigma = 0 it is a spring that bends, below that it makes energy:
both are refused.

The step along a monotone path is exact for every n (`dampyr.models.numerics.bouc_wen_exact`).
The letters of equations (2.1) and (2.2) of Raminelli (2020) are converted by `from_printed` and `to_printed`. Sets of them with
:math:`\beta + \gamma \le 0` harden, z has no limit, and they are refused: `hardening_bouc_wen` has them. Loops that pinch
and degrade are those of `bouc_wen_baber_noori`, a sharp corner that of `bilinear`.

Bouc (1971); Wen (1976); the normalised form: Ikhouane and Rodellar (2007).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign
from typing import Annotated

from dampyr.errors import InputError
from dampyr.models.numerics.bouc_wen_exact import flow
from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

HOLDS = ("spring",)
# where sigma is 1000, friction leaves its limit on a thousandth of the path that led there
MAX_SIGMA = 1000.0
MAX_EXPONENT = 50.0  # of n: the loop is a parallelogram to the eye
STATES = {"w": (-1.0, 1.0)}
EXAMPLE = {"c0": 500.0, "k0": 5e3, "kw": 350.0, "rho": 600.0, "sigma": 2.0, "n": 2.0}


@checked
@dataclass(frozen=True)
class BoucWen:
    """Dashpot ``c0``, spring ``k0``, hysteretic force ``kw``, ``rho``, the shape ``sigma`` and the exponent ``n``."""

    c0: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    k0: Annotated[float, Quantity("N/m", linear=True)]
    kw: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]
    sigma: Annotated[float, Quantity("", low=0, high=MAX_SIGMA, open_low=True)]
    n: Annotated[float, Quantity("", low=1, high=MAX_EXPONENT)]


def advance(w: float, x0: float, x1: float, rho: float, sigma: float, n: float) -> float:
    s = copysign(1.0, x1 - x0)
    return s * flow(s * w, rho * abs(x1 - x0), n, 2.0 * sigma - 1.0)


def rates(w: float, v: float, rho: float, sigma: float, n: float) -> float:
    h = abs(w) ** n
    return rho * (v - sigma * abs(v) * copysign(h, w) + (sigma - 1.0) * v * h)


def switches(v: float) -> float:
    return v


def force(w: float, x: float, v: float, c0: float, k0: float, kw: float) -> float:
    return c0 * v + k0 * x + kw * w


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (0.3, 0.03):
        for n in (1.05, 2.0):
            yield {"rho": 1.0 / (path * scale.stroke), "sigma": 1.0, "n": n}


@dataclass(frozen=True)
class PrintedBoucWen:
    r"""The letters of (2.1) and (2.2), with alpha z in the force (the printed alpha dz/dt has the wrong units).

    .. math:: F = c_0 v + k_0 (x - x_0) + \alpha z, \quad
              \dot z = -\gamma z |v| |z|^{n-1} - \beta v |z|^n + A v
    """

    c0: float
    k0: float
    alpha: float
    A: float
    beta: float
    gamma: float
    n: float

    @property
    def z_max(self) -> float:
        r"""The ultimate value :math:`(A/(\beta+\gamma))^{1/n}` of z."""
        if self.A <= 0 or self.beta + self.gamma <= 0:
            raise InputError(
                f"A = {self.A:g} and beta + gamma = {self.beta + self.gamma:g} give a state without bound; "
                "both must be greater than 0; hardening_bouc_wen has sets that harden"
            )
        return float((self.A / (self.beta + self.gamma)) ** (1.0 / self.n))


def from_printed(c0: float, k0: float, alpha: float, A: float, beta: float, gamma: float, n: float) -> BoucWen:
    r"""The normalised model of a printed parameter set.

    .. math:: \rho = A/z_\max, \quad \sigma = \gamma/(\beta+\gamma), \quad k_w = \alpha z_\max

    ``gamma`` multiplies \|v\| z and ``beta`` multiplies v \|z\|^n, as in (2.2); Ikhouane and Rodellar and OpenSees swap
    the two. Raises :class:`~dampyr.errors.InputError` where the set is unbounded or makes energy (gamma <= 0).
    """
    z_max = PrintedBoucWen(c0, k0, alpha, A, beta, gamma, n).z_max
    if gamma <= 0:
        raise InputError(f"gamma = {gamma:g} gives sigma <= 0: the loop makes energy; gamma must be greater than 0")
    return BoucWen(c0=c0, k0=k0, kw=alpha * z_max, rho=A / z_max, sigma=gamma / (beta + gamma), n=n)


def to_printed(model: BoucWen, A: float = 1.0) -> PrintedBoucWen:
    """The printed letters of a normalised model, with the free scale of z fixed by ``A``."""
    if A <= 0:
        raise InputError(f"A = {A:g} is not allowed; the scale of z must be greater than 0")
    z_max = A / model.rho
    total = A / z_max**model.n
    return PrintedBoucWen(
        c0=model.c0,
        k0=model.k0,
        alpha=model.kw / z_max,
        A=A,
        beta=(1.0 - model.sigma) * total,
        gamma=model.sigma * total,
        n=model.n,
    )
