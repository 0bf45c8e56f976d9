r"""The Bingham model: a dashpot beside Coulomb friction, its sign rolled off over a small velocity.

.. math:: F = c_0 v + f_c\,\operatorname{sgn}(v)\left(1 - e^{-|v|/v_0}\right)

The model as published is the limit v0 -> 0, :math:`F = c_0 v + f_c \operatorname{sgn} v`. Its jump at v = 0 has no force at
rest and lets no building settle, so the yield of Bingham's fluid is regularised as in Papanastasiou's: the force is within
:math:`f_c e^{-|v|/v_0}` of the published one, and at rest it creeps as a dashpot of fc/v0. To have the published model
in a fit, hold v0 far below the speeds of the record (``fixed={"bingham.v0": 1e-5}``). It has no memory and no loop
in the force-velocity plane: use `dahl` or `bouc_wen` where a record shows one.

Stanway, Sproston and Stevens (1987), Journal of Electrostatics 20, 167; Spencer et al. (1997);
the regularisation: Papanastasiou (1987), Journal of Rheology 31, 385.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, exp
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

EXAMPLE = {"c0": 1500.0, "fc": 300.0, "v0": 0.001}


@checked
@dataclass(frozen=True)
class Bingham:
    """Viscous friction ``c0``, Coulomb friction ``fc`` and the velocity ``v0`` over which its sign changes."""

    c0: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    fc: Annotated[float, Quantity("N", low=0, linear=True)]
    v0: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def force(v: float, c0: float, fc: float, v0: float) -> float:
    return c0 * v + fc * copysign(1.0, v) * (1.0 - exp(-abs(v) / v0))


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.2, 0.02):
        yield {"v0": part * scale.speed}
