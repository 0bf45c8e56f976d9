r"""A pure delay of the whole force.

.. math:: F(t) = F_\text{other parts}(t - \tau)

Until the motion has lasted tau, the force is the one at the start. Between samples of a path the force is interpolated
linearly, of second order in the step.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import Scale, checked
from dampyr.units import Quantity

ADD_ON = True
DELAY = "tau"
EXAMPLE = {"tau": 0.03}


@checked
@dataclass(frozen=True)
class Delay:
    """The delay ``tau``."""

    tau: Annotated[float, Quantity("s", low=0)]


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    yield {"tau": scale.dt}
