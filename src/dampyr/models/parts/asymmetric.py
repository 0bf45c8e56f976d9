r"""The asymmetric damper: dashpot and friction with numbers of their own in extension and in compression.

.. math:: F = \begin{cases} c_e v + f_e \tanh(v/v_0) & v \ge 0 \\ c_c v + f_c \tanh(v/v_0) & v < 0 \end{cases}

v is positive in extension (rebound); what vehicle engineers call bump is compression. With :math:`c_e = c_c` and
:math:`f_e = f_c` it is `hyperbolic_tangent` without its shift. It has no memory and dissipates whatever the motion. In a
record of a sine the two directions are told apart by the force alone; a force that is unlike because of the gas is that of
`offset` and `gas_spring`, which the velocity does not change.

A model with memory that pulls otherwise than it pushes is `asymmetric_bouc_wen`.

The bilinear characteristic of vehicle shock absorbers, as in Dixon (2007), The Shock Absorber Handbook.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import tanh
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

EXAMPLE = {"ce": 3000.0, "cc": 1200.0, "fe": 250.0, "fc": 100.0, "v0": 0.01}


@checked
@dataclass(frozen=True)
class Asymmetric:
    """Damping and friction in extension, ``ce`` and ``fe``, in compression, ``cc`` and ``fc``; the velocity ``v0``."""

    ce: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    cc: Annotated[float, Quantity("N s/m", low=0, linear=True)]
    fe: Annotated[float, Quantity("N", low=0, linear=True)]
    fc: Annotated[float, Quantity("N", low=0, linear=True)]
    v0: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def force(v: float, ce: float, cc: float, fe: float, fc: float, v0: float) -> float:
    if v < 0.0:
        return cc * v + fc * tanh(v / v0)
    return ce * v + fe * tanh(v / v0)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for part in (0.3, 0.05):
        yield {"v0": part * scale.speed}
