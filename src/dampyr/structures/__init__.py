"""Buildings, dampers in their storeys, and what they do in an earthquake.

``respond(building, motion, dampers={storey: damper}, voltage=...)`` marches a building through a ground
motion; ``two_storey()`` is the building of chapter 5, ``Building(M, C, K)`` and ``shear_building(...)``
make others, ``state_space`` writes one as matrices.
"""

from dampyr.structures.building import Building, shear_building, two_storey
from dampyr.structures.respond import respond
from dampyr.structures.response import Energy, Response
from dampyr.structures.state_space import StateSpace, state_space

__all__ = [
    "Building",
    "two_storey",
    "shear_building",
    "respond",
    "Response",
    "Energy",
    "state_space",
    "StateSpace",
]
