r"""An inertance: a force in proportion to the relative acceleration of the two ends.

.. math:: F = m\,\dot v

The mass of what moves with the rod, or of an inerter between two floors. In a building it is solved together with the
floors' masses. Along a record the acceleration is the central difference of the velocity, of second order in the step, and only
as good as the velocity is. Behind a `compliance` or `free_play` it feels the motion of the outer end.

Smith (2002), IEEE Transactions on Automatic Control 47, 1648.
"""

from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import checked
from dampyr.units import Quantity

ADD_ON = True
EXAMPLE = {"m": 300.0}


@checked
@dataclass(frozen=True)
class Inertia:
    """The inertance ``m``."""

    m: Annotated[float, Quantity("kg", low=0, linear=True)]


def force(a: float, m: float) -> float:
    return m * a
