r"""The hyperbolic tangent model: friction that rolls off over a velocity.

.. math:: F = c v + f_t \tanh\frac{v + s x}{v_0}

The force changes sign smoothly over the velocity v0; s x shifts that change with the position and opens a loop in the
force-velocity plane. It has no memory: use `dahl` or `bouc_wen` where the loop depends on the path.

Kwok et al. (2006) with the position in the place of their sign(x), as in Gavin (2001).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import tanh
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

EXAMPLE = {"c": 1200.0, "ft": 300.0, "v0": 0.02, "s": -1.5}


@checked
@dataclass(frozen=True)
class HyperbolicTangent:
    """Viscous friction ``c``, the friction ``ft`` at high speed, the velocity ``v0`` and the shift ``s``."""

    c: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    ft: Annotated[float, Quantity("N", low=0, linear=True)]
    v0: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    s: Annotated[float, Quantity("1/s")]


def force(x: float, v: float, c: float, ft: float, v0: float, s: float) -> float:
    return c * v + ft * tanh((v + s * x) / v0)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.3, 0.1):
        yield {"v0": part * scale.speed, "s": 0.0}
