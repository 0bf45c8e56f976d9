r"""The generalised Maxwell model: a spring beside three Maxwell arms whose time constants are a decade apart.

.. math:: F = k_0 x + \sum_{i=1}^3 k_i e_i, \qquad \dot e_i = v - \frac{e_i}{\tau_i}, \qquad \tau_i = 10^{i-1}\,\tau

for rubber, viscoelastic dampers and elastomeric mounts: :math:`e_i` is the stretch of the spring of an arm, a spring in series
with a dashpot :math:`k_i \tau_i`. The relaxation after a step is the Prony series
:math:`k_0 + \sum k_i e^{-t/\tau_i}`; a sine of the frequency omega meets the stiffness :math:`k_0 + \sum k_i
(\omega\tau_i)^2/(1 + (\omega\tau_i)^2)` and the loss stiffness :math:`\sum k_i \omega\tau_i/(1 + (\omega\tau_i)^2)`. With one
time constant a decade only tau, the shortest, is not linear, and nothing is to be chosen; the
loss stiffness of a material that relaxes alike at all times between is met to 5.5 %. With one stiffness of the three it is the
standard linear solid of Zener, with k0 = 0 too a single Maxwell arm; then a fit may give that arm as the first, second or
third, with the same force. A dashpot behind a `compliance` is a Maxwell arm too, in series with all of the damper.

Records should hold frequencies near all :math:`1/(2\pi\tau_i)`: an arm much slower than the records is part of a spring, and
a much faster one a dashpot, whose stiffness and time constant are not told apart. It is linear in the motion: rubber that
softens with the amplitude (Payne, Mullins) needs `maxwell_slip` beside it. Its stiffness and tau hold at one temperature.

A step takes the velocity as constant between samples, and is exact then, however long; otherwise of second order. Its stretch
begins within the stroke of all records. It dissipates whatever the motion: the dashpots take :math:`k_i e_i^2/\tau_i`.

Kaliske and Rothert (1997), Computational Mechanics 19, 228: the model with any number of arms, and its step.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import exp, inf
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.models.parts._relaxation import phi_1
from dampyr.units import Quantity

HOLDS = ("spring",)
STATES = {"e1": (-inf, inf), "e2": (-inf, inf), "e3": (-inf, inf)}
WITHIN_STROKE = ("e1", "e2", "e3")
EXAMPLE = {"k0": 10e3, "k1": 20e3, "k2": 20e3, "k3": 20e3, "tau": 0.05}


@checked
@dataclass(frozen=True)
class GeneralisedMaxwell:
    """The spring ``k0``, the arms ``k1``, ``k2`` and ``k3``, and ``tau``, the time constant of the first."""

    k0: Annotated[float, Quantity("N/m", low=0, linear=True)]
    k1: Annotated[float, Quantity("N/m", low=0, linear=True)]
    k2: Annotated[float, Quantity("N/m", low=0, linear=True)]
    k3: Annotated[float, Quantity("N/m", low=0, linear=True)]
    tau: Annotated[float, Quantity("s", low=0, open_low=True)]


def advance(e1: float, e2: float, e3: float, x0: float, x1: float, dt: float, tau: float) -> tuple[float, float, float]:
    turns = dt / tau
    step = x1 - x0
    return (
        e1 * exp(-turns) + step * phi_1(turns),
        e2 * exp(-0.1 * turns) + step * phi_1(0.1 * turns),
        e3 * exp(-0.01 * turns) + step * phi_1(0.01 * turns),
    )


def rates(e1: float, e2: float, e3: float, v: float, tau: float) -> tuple[float, float, float]:
    return v - e1 / tau, v - 0.1 * e2 / tau, v - 0.01 * e3 / tau


def force(e1: float, e2: float, e3: float, x: float, k0: float, k1: float, k2: float, k3: float) -> float:
    return k0 * x + k1 * e1 + k2 * e2 + k3 * e3


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.003, 0.03, 0.3):
        yield {"tau": part * scale.stroke / scale.speed}
