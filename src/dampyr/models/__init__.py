"""Models of hysteresis, the laws by which they follow the input, and dampers made of them.

A *part* is one model or add-on (`available_parts` lists them), a *damper* is a composition of parts with one *law* per
parameter over the coil's voltage or current. `Damper.force` gives the force along a path, `Damper.load` and `Damper.save`
read and write its card. `published` holds parameter sets from the literature.
"""

from dampyr.models import published
from dampyr.models.codegen.composition import compose
from dampyr.models.damper import Damper
from dampyr.models.laws import Constant, Interpolation, Polynomial, WithTemperature
from dampyr.models.part import REGISTRY
from dampyr.registry import names

__all__ = [
    "available_parts", "Constant", "Damper", "Interpolation", "Polynomial", "WithTemperature", "compose", "published",
]  # fmt: skip


def available_parts() -> list[str]:
    """The names of all parts."""
    return names(REGISTRY)
