r"""The LuGre model: bristles that bend, slip and let go more easily the faster they are dragged.

.. math:: F = f_s w + \sigma_1\left(v - |v|\frac{w}{h(v)}\right) + \sigma_2 v, \qquad
          \dot w = \frac{\rho}{1+e}\left(v - |v|\frac{w}{h(v)}\right), \qquad
          h(v) = \frac{1 + e\,\exp(-(v/v_s)^2)}{1+e}

In the letters of the source, :math:`g(v) = f_c + (f_s - f_c)\exp(-(v/v_s)^2)` is the friction at a steady speed, from the
static fs down to Coulomb's fc; here :math:`e = f_s/f_c - 1` is the excess of the static friction,
:math:`w = \sigma_0 z/f_s` stays in [-1, 1], :math:`\rho = \sigma_0/f_c`, and what the source multiplies by :math:`\dot z` is in
the first bracket. With e = 0 and sigma1 = 0 it is the Dahl model, rho and all. It dissipates whatever the motion if
:math:`\sigma_2 \ge e\,\sigma_1` (Barabanov and Ortega); with more sigma1 it may make energy at high speed.
A sine passes the low speeds quickly and holds e and vs only weakly: fit records of several frequencies together.

Along a piece of path the equation is linear in w; its target h is taken as linear and its rate as the mean over the
piece by Simpson's rule, the velocity being linear between v0 and v1. Exact at constant speed, however long the piece;
otherwise of second order in the step. Where the motion crosses vs within a sample that is not small: half of the peak force at
one sample where 200 a second step over a vs of 1 mm/s. `dampyr.models.sampling_error` measures it, and a warning tells it.

Canudas de Wit, Olsson, Astrom and Lischinsky (1995), IEEE Transactions on Automatic Control 40, 419;
Barabanov and Ortega (2000), the same 45, 830; for magnetorheological dampers: Jimenez and Alvarez-Icaza (2005), Structural
Control and Health Monitoring 12, 91.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, exp
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

SPEED = "vs"  # friction falls within it, so that samples which step over it miss that
STATES = {"w": (-1.0, 1.0)}  # the equation cannot leave it
SHORT = 1e-4  # below it the series of (1 - exp(-t))/t to t^2 is right to t^3/24 < 5e-14
EXAMPLE = {"fc": 300.0, "sigma1": 0.0, "sigma2": 800.0, "rho": 1000.0, "e": 0.6, "vs": 0.02}


@checked
@dataclass(frozen=True)
class Lugre:
    """Coulomb friction ``fc``, ``sigma1``, ``sigma2``, ``rho``, the excess ``e`` of the static friction, and ``vs``."""

    fc: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    sigma1: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    sigma2: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    rho: Annotated[float, Quantity("1/m", low=0, open_low=True)]
    e: Annotated[float, Quantity("", low=0)]
    vs: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def advance(w: float, x0: float, x1: float, v0: float, v1: float, rho: float, e: float, vs: float) -> float:
    s = copysign(1.0, x1 - x0)
    h0 = (1.0 + e * exp(-((v0 / vs) ** 2))) / (1.0 + e)
    hm = (1.0 + e * exp(-((0.5 * (v0 + v1) / vs) ** 2))) / (1.0 + e)
    h1 = (1.0 + e * exp(-((v1 / vs) ** 2))) / (1.0 + e)
    turns = rho * abs(x1 - x0) / (1.0 + e) * (1.0 / h0 + 4.0 / hm + 1.0 / h1) / 6.0
    decay = exp(-turns)
    if turns < SHORT:
        lag = 1.0 - turns * (0.5 - turns / 6.0)
    else:
        lag = (1.0 - decay) / turns
    return s * h1 + (w - s * h0) * decay - s * (h1 - h0) * lag


def rates(w: float, v: float, rho: float, e: float, vs: float) -> float:
    h = (1.0 + e * exp(-((v / vs) ** 2))) / (1.0 + e)
    return rho / (1.0 + e) * (v - abs(v) * w / h)


def switches(v: float) -> float:
    return v


def force(w: float, v: float, fc: float, sigma1: float, sigma2: float, e: float, vs: float) -> float:
    h = (1.0 + e * exp(-((v / vs) ** 2))) / (1.0 + e)
    return fc * (1.0 + e) * w + sigma1 * (v - abs(v) * w / h) + sigma2 * v


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for path in (0.1, 0.03, 0.01):
        for speed in (0.3, 0.1):
            yield {"rho": 1.0 / (path * scale.stroke), "e": 0.3, "vs": speed * scale.speed}
