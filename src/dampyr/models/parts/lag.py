r"""A lag of the input behind its command: the current in a coil of resistance R and inductance L.

.. math:: \tau \dot u = u_c - u, \qquad \tau = L/R

uc is the command that a record or a controller gives, u the input that the laws of the other parts follow; at the start
they are equal. Between samples the command is a straight line, and the step is exact. A constant command lags behind nothing:
tests at constant voltage say nothing about tau.

The first-order filter of Spencer, Dyke, Sain and Carlson (1997), Journal of Engineering Mechanics 123, 230, there
:math:`\eta = 1/\tau`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True
LAG = "tau"
EXAMPLE = {"tau": 0.05}


@checked
@dataclass(frozen=True)
class Lag:
    """The time constant ``tau``."""

    tau: Annotated[float, Quantity("s", low=0)]


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    yield {"tau": 0.01}
