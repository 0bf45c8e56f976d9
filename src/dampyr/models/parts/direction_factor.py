r"""A factor by direction on the force of the other parts: models with memory that pull otherwise than they push.

.. math:: F = \left(1 + e \tanh\frac{v}{v_0}\right) \sum_\text{other parts} F_k

v is positive in extension, so the force there is 1 + e times that of the model and in compression 1 - e times. v0 rounds the
change; a fit needs samples within it to find it, so hold it (``fixed=``) where it is not of interest. `offset` and `inertia`
are not multiplied. For a damper without memory `asymmetric` has numbers of its own in each direction, and loops whose shape
differs are those of `asymmetric_bouc_wen`. A leaderboard does not add it by itself.

Do not use it for a building: what a spring or a memory has stored comes back with another factor than it went in with, so a
cycle about a place off the middle may make energy. It cannot stand with an element in series (`compliance`, `free_play`).

The factor of the two directions of vehicle shock absorbers, as in Dixon (2007), The Shock Absorber Handbook, here on any model.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import tanh
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True
CONSTANT = ("v0",)
NOT_FOR_BUILDINGS = "what is stored comes back with another factor; use asymmetric or asymmetric_bouc_wen"
EXAMPLE = {"e": 0.3, "v0": 0.005}


@checked
@dataclass(frozen=True)
class DirectionFactor:
    """The half difference ``e`` of the factors, and the velocity ``v0`` within which they change over."""

    e: Annotated[float, Quantity("", low=-0.95, high=0.95)]
    v0: Annotated[float, Quantity("m/s", low=0, open_low=True)]


def factor(v: float, e: float, v0: float) -> float:
    return 1.0 + e * tanh(v / v0)


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for e in (0.2, -0.2):
        yield {"e": e, "v0": 0.05 * scale.speed}
