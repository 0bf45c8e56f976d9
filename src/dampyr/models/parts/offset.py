r"""A constant force: the gas in the accumulator and the zero of the sensor.

.. math:: F = f_0

A building is at rest in its equilibrium with it, so the response of a building leaves it out.
"""

from dataclasses import dataclass
from typing import Annotated

from dampyr.models.part import checked
from dampyr.units import Quantity

ADD_ON = True
STATIC = True
EXAMPLE = {"f0": 150.0}


@checked
@dataclass(frozen=True)
class Offset:
    """The constant force ``f0``."""

    f0: Annotated[float, Quantity("N", linear=True)]


def force(f0: float) -> float:
    return f0
