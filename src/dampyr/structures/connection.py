"""Between which floors a damper stands: a storey, or any two floors, of which one may be the ground.

A *place* is a storey, a number from 1 up, or a pair of floors, each by its label or its count from 1; 0 or
"ground" is the ground. (i-1, i) is storey i.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.structures.building import Building

Array = NDArray[np.float64]
GROUND = ("0", "ground")


def normal(building: Building, place: Any) -> int | tuple[int, int]:
    """The storey as an int where the place is one, else the pair of counts, 0 for the ground."""
    if not isinstance(place, list | tuple):
        return _storey(building, place)
    if len(place) != 2:
        raise InputError(f"{place!r} names {len(place)} floors; a damper stands between 2, such as (0, 2)")
    first, second = (counted(building.floors, each, building.name) for each in place)
    if first == second:
        raise InputError(f"{place!r} joins floor {second} to itself; a damper needs two different ends")
    return second if second == first + 1 else (first, second)


def row(building: Building, place: Any) -> Array:
    """The row (n,) that turns floor displacements into the stroke q_j - q_i of a damper from i to j."""
    there = normal(building, place)
    first, second = (there - 1, there) if isinstance(there, int) else there
    values = np.zeros(building.n + 1)
    values[first], values[second] = -1.0, 1.0
    return values[1:]


def label(building: Building, place: Any) -> str:
    """What a response calls a place: "storey 1", or the labels of its floors as in "0-2"."""
    there = normal(building, place)
    if isinstance(there, int):
        return f"storey {there}"
    return "-".join(GROUND[0] if k == 0 else building.floors[k - 1] for k in there)


def describe_place(place: int | tuple[int, int]) -> str:
    """A place inside a sentence: "in storey 1", "between floors 0 and 2"."""
    return f"in storey {place}" if isinstance(place, int) else f"between floors {place[0]} and {place[1]}"


def counted(floors: Sequence[str], name: Any, owner: str) -> int:
    """A floor by label (text) or count (a whole number), as its count; 0 is the ground."""
    if isinstance(name, str):
        if name in GROUND or name in floors:
            return 0 if name in GROUND else list(floors).index(name) + 1
    elif isinstance(name, int | np.integer) and not isinstance(name, bool) and 0 <= name <= len(floors):
        return int(name)
    raise InputError(
        f"floor {name!r} is not in {owner}; write 0 for the ground, a whole number up to {len(floors)}, "
        f"or a label: {', '.join(floors)}"
    )


def _storey(building: Building, storey: Any) -> int:
    if isinstance(storey, bool) or not isinstance(storey, int | np.integer) or not 1 <= storey <= building.n:
        raise InputError(
            f"storey {storey!r} is not in {building.name}; storeys are whole numbers "
            f"from 1 (ground to first floor) to {building.n}"
        )
    return int(storey)
