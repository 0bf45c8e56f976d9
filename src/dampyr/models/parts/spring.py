r"""A linear spring.

.. math:: F = k_0 x

The position is measured from where the record or the building has its zero; what that choice adds is the `offset`.
Equation (2.1) of Raminelli (2020) has the two together: k0 (x - x0).
"""

from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import checked
from dampyr.units import Quantity

ADD_ON = True
EXAMPLE = {"k0": 15e3}


@checked
@dataclass(frozen=True)
class Spring:
    """Stiffness ``k0``; it may be negative in a fit, where it makes up for curvature that the other parts lack."""

    k0: Annotated[float, Quantity("N/m", linear=True)]


def force(x: float, k0: float) -> float:
    return k0 * x
