r"""The bilinear model: elastic up to a yield displacement, then a straight line of a lower stiffness.

.. math:: F = k_2 x + Q w, \qquad
          \dot w = \begin{cases} v/u_y & \text{while } -1 < w < 1 \\ 0 & \text{where } w \text{ is held at } \pm 1 \end{cases}

of a yielding brace, a buckling-restrained one, a lead-rubber bearing, a sliding bearing. Q is the characteristic strength, the
force at x = 0 of a cycle that yields; :math:`u_y` is the yield displacement and :math:`k_2` the stiffness after it. In other
letters the initial stiffness is :math:`k_1 = k_2 + Q/u_y`, the yield force :math:`F_y = k_1 u_y = Q + k_2 u_y` and the
hardening ratio :math:`b = k_2/k_1` (OpenSees' Steel01 without its shifts). With k2 = 0 it is elastic and perfectly plastic.

w is the stop operator, a spring in series with a slider (Jenkin's element): `maxwell_slip` has four of them, slipping after
paths of 1 : 3 : 5 : 7, and a dashpot, and its corner is round; here there is one, whose corner is sharp, and the `spring`
beside it, which is not to be added again. Where the corner of a record is round use `maxwell_slip`, `dahl` or `bouc_wen`, each
with `spring`. It has no rate: where the force grows with the frequency add `power_law`, which is a dashpot with alpha = 1.

The step along a monotone piece is exact, however long. It dissipates whatever the motion: :math:`Q w v` is the work of the
slider and the change of :math:`\tfrac12 Q u_y w^2`. Its strength never falls: a brace that buckles or tears is not described.

Iwan (1966), Journal of Applied Mechanics 33, 893; Visintin (1994), Differential Models of Hysteresis; in buildings: Chopra
(2017), Dynamics of Structures.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.units import Quantity

HOLDS = ("spring",)
STATES = {"w": (-1.0, 1.0)}  # where it yields
EXAMPLE = {"Q": 300.0, "uy": 0.002, "k2": 15e3}


@checked
@dataclass(frozen=True)
class Bilinear:
    """Characteristic strength ``Q``, yield displacement ``uy`` and stiffness ``k2`` after yield."""

    Q: Annotated[float, Quantity("N", low=0, open_low=True, linear=True)]
    uy: Annotated[float, Quantity("m", low=0, open_low=True)]
    k2: Annotated[float, Quantity("N/m", low=0, linear=True)]


def advance(w: float, x0: float, x1: float, uy: float) -> float:
    return slip(w, (x1 - x0) / uy)


def force(w: float, x: float, Q: float, k2: float) -> float:
    return k2 * x + Q * w


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.2, 0.07, 0.02, 0.005):
        yield {"uy": part * scale.stroke}
