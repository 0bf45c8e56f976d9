r"""A structure on isolators: a slab below it that moves, and what carries the slab as an element of its first storey.

With the displacement b of the slab relative to the ground, and q of the structure's coordinates relative to the ground too,

.. math:: M_i = \begin{pmatrix} m_b & 0 \\ 0 & M \end{pmatrix}, \quad
          K_i = T^T K T + \begin{pmatrix} k_b & 0 \\ 0 & 0 \end{pmatrix}, \quad T = (-\iota \;\; I)

and so C: the structure's springs and dashpots act on what it moves beside the slab, :math:`q - \iota b`. The isolators' force
beyond the linear share :math:`k_b, c_b` is that of any damper between ground and slab. The vertical load is what a part such as
`triple_pendulum` is given; nothing rocks and nothing lifts.

Reference: F. Naeim and J. M. Kelly, Design of Seismic Isolated Structures (1999), chapter 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dampyr.argument_kinds import BUILDING, DAMPER, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.structures.building import Building, Condensed
from dampyr.structures.supports import refuse_supports
from dampyr.units import in_si


def isolated(
    building: Building,
    base_mass: float,
    isolators: Damper,
    stiffness: float = 0.0,
    dashpot: float = 0.0,
    elements: Mapping[Any, Any] | None = None,
    name: str = "",
) -> tuple[Building, dict[int, Any]]:
    """A structure on isolators, for `respond` and `ensemble`: the building with a slab below it, and its elements.

    Storey 1 is the isolators then, and the structure's own storeys count from 2. A damper beside them stands in a list,
    ``elements | {1: [elements[1], damper]}``.

    Parameters
    ----------
    building
        The structure, with a fixed base; not one that was reduced.
    base_mass
        kg of the slab.
    isolators
        All of them together, as a damper without an input: `bilinear` for lead and rubber, `triple_pendulum` for sliders.
    stiffness, dashpot
        N/m and N s/m of what is linear in them beside that, such as the rubber.
    elements
        Those of the structure's storeys, as `yielding_shear_building` gives them.
    name
        What it is called; by default after the structure.

    Raises
    ------
    InputError
        A number is not allowed, the structure was reduced, or elements stand between other floors than a storey's.

    Examples
    --------
    >>> import dampyr as dp
    >>> S = dp.structures
    >>> house = S.shear_building([2e4, 2e4], [3e7, 2e7], damping_ratio=0.02)
    >>> values = {"bilinear.Q": 3e4, "bilinear.uy": 0.01, "bilinear.k2": 0.0}
    >>> rubber = dp.models.Damper("bilinear", values, input="none")
    >>> building, elements = S.isolated(house, 2e4, rubber, stiffness=4e5)
    >>> response = S.respond(building, dp.ground_motions.el_centro(), elements)
    >>> fixed = S.respond(house, dp.ground_motions.el_centro())
    >>> bool(response.peak_drift[1] < 0.3 * fixed.peak_drift[0])
    True
    """
    check_kinds(
        "isolated",
        Argument("building", building, (Building,), BUILDING),
        Argument("isolators", isolators, (Damper,), DAMPER),
    )
    refuse_supports("isolated", building)
    if not building.is_stack:
        raise InputError(f"the floors of {building.name} do not stand one on the other, as above a slab they must")
    if isinstance(building, Condensed):
        raise InputError(f"{building.name} was reduced, and its coordinates are no floors; isolate the whole structure")
    numbers = {
        key: float(in_si(value, unit, key))
        for key, value, unit in (
            ("base_mass", base_mass, "kg"), ("stiffness", stiffness, "N/m"), ("dashpot", dashpot, "N s/m"),
        )
    }  # fmt: skip
    for key, value in numbers.items():
        if not (value > 0.0 if key == "base_mass" else value >= 0.0) or not np.isfinite(value):
            allowed = "greater than 0" if key == "base_mass" else "at least 0"
            raise InputError(f"{key} = {value:g} is not allowed; it must be {allowed}")
    moved: dict[int, Any] = {1: isolators}
    for place, element in (elements or {}).items():
        storey = building.resolve_place(place)
        if not isinstance(storey, int):
            raise InputError(f"an element between {place} stands in no storey; give elements of storeys alone")
        moved[storey + 1] = element
    n = building.n
    beside = np.hstack([-building.influence[:, None], np.eye(n)])
    base = np.zeros(n + 1)
    base[0] = 1.0
    M = np.zeros((n + 1, n + 1))
    M[0, 0], M[1:, 1:] = numbers["base_mass"], building.M
    return (
        Building(
            M,
            beside.T @ building.C @ beside + numbers["dashpot"] * np.outer(base, base),
            beside.T @ building.K @ beside + numbers["stiffness"] * np.outer(base, base),
            name or f"{building.name} on isolators",
            ("base", *building.floors),
            np.append(1.0, building.influence),
        ),
        moved,
    )
