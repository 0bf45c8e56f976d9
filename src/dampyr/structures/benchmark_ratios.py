r"""Criteria of benchmark control problems: what a controlled response is beside that without dampers, as ratios.

With d the storey drifts over their heights, :math:`\ddot x_a` the absolute accelerations, V the base shear, f and y force and
stroke of the dampers, x the displacements relative to the ground, W the building's weight, subscript u the response without
dampers, and :math:`\|s\| = \sqrt{\tfrac1T \int s^2 dt}`:

.. math:: J_1 = \frac{\max |d|}{\max |d_u|}, \quad J_2 = \frac{\max |\ddot x_a|}{\max |\ddot x_{a,u}|}, \quad
          J_3 = \frac{\max |V|}{\max |V_u|}, \quad J_4, J_5, J_6 \text{ the same of } \|\cdot\|, \quad
          J_{11} = \frac{\max |f|}{W}, \quad J_{12} = \frac{\max |y|}{\max |x_u|}

Of storeys that yield, with :math:`\mu = d / d_y` their ductility, E the energy that their hysteresis has taken at the end and N
how many have yielded:

.. math:: J_7 = \frac{\max |\mu|}{\max |\mu_u|}, \quad J_8 = \frac{\max E}{\max E_u}, \quad
          J_9 = \frac{N}{N_u}, \quad J_{10} = \frac{\max \|\mu\|}{\max \|\mu_u\|}

where the benchmark has the curvature and the energy of the ends of its members. :math:`J_{13}` and :math:`J_{14}` are of
the power that the dampers take, which no card states, and :math:`J_{15}` to :math:`J_{17}` count devices, sensors and the
controller's states.

Reference: Y. Ohtori, R. E. Christenson, B. F. Spencer and S. J. Dyke, Benchmark control problems for seismically excited
nonlinear buildings, Journal of Engineering Mechanics 130 (2004) 366-385.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.input_kinds import NO_INPUT
from dampyr.structures.building import Building
from dampyr.structures.time_history.peaks import storey_heights
from dampyr.structures.time_history.response import Response
from dampyr.structures.yielding import per_storey
from dampyr.units import STANDARD_GRAVITY

Array = NDArray[np.float64]


def benchmark_criteria(
    response: Response,
    bare: Response,
    building: Building,
    height: ArrayLike = 1.0,
    yield_drifts: ArrayLike | None = None,
) -> dict[str, float]:
    """Criteria J1 to J12 of a response with dampers, by their names: ratios, 1 without control for the first ten.

    J7 to J10 are of storeys that yield and need ``yield_drifts``; J8 and J9 are left out where none yields without dampers.

    Parameters
    ----------
    response, bare
        What `respond` gave for the same building and motion, with dampers and without.
    building
        The building, whose weight J11 is over.
    height
        m, of all storeys or one each; where all are equal it does not matter.
    yield_drifts
        m, of all storeys or one each, where they yield (`yielding_shear_building`). ``bare`` then has the elements of the
        storeys, and ``response`` too, each before the dampers of its storey: ``elements | {1: [elements[1], damper]}``.

    Raises
    ------
    InputError
        The two responses are not of the same motion or of as many floors, or the second has dampers.

    Examples
    --------
    >>> import dampyr as dp
    >>> S, building, motion = dp.structures, dp.structures.two_storey(), dp.ground_motions.el_centro()
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> bare, held = S.respond(building, motion), S.respond(building, motion, damper, voltage=1.98)
    >>> {name: round(value, 3) for name, value in S.benchmark_criteria(held, bare, building).items()}
    {'J1': 0.208, 'J2': 0.354, 'J3': 0.346, 'J4': 0.263, 'J5': 0.426, 'J6': 0.328, 'J11': 0.273, 'J12': 0.107}
    """
    if not np.array_equal(response.ground_acceleration, bare.ground_acceleration) or response.loads is not bare.loads:
        raise InputError(
            "the two responses are of different motions or loads; give both of the same motion, loads and rest"
        )
    if len(response.drift) != len(bare.drift) or len(response.drift) != building.n_floors:
        raise InputError(
            f"the responses have {len(response.drift)} and {len(bare.drift)} floors and {building.name} {building.n_floors}; "
            "give those of one building"
        )
    if bare.sites and (yield_drifts is None or any(unit != NO_INPUT for unit in bare.input_units)):
        raise InputError(
            "bare has dampers; give the response of the building without any (of storeys that yield, with their elements alone "
            "and yield_drifts=)"
        )
    if yield_drifts is not None and not bare.sites:
        raise InputError("yield_drifts= is of storeys that yield, and bare has no elements that do; leave it out")
    members = _members(response, bare)
    dampers = [k for k in range(len(response.sites)) if k not in members]
    largest, norms = _relative_to(storey_heights(height, building.n_floors), response, bare)
    found = {
        "J1": largest[0] / largest[1],
        "J2": float(response.peak_acceleration.max() / bare.peak_acceleration.max()),
        "J3": response.peak_base_shear / bare.peak_base_shear,
        "J4": norms[0] / norms[1],
        "J5": _norm(response.acceleration) / _norm(bare.acceleration),
        "J6": _norm(response.base_shear[None]) / _norm(bare.base_shear[None]),
    }
    if yield_drifts is not None:
        found |= _of_yielding(response, bare, members, per_storey("yield_drifts", yield_drifts, building.n_floors))
    if dampers:
        # the mass that follows the ground, all of it where the structure is a reduced one
        mass = float(building.influence @ building.M @ building.carried) + building.ground_terms()[1]
        found["J11"] = float(response.peak_force[dampers].max()) / (STANDARD_GRAVITY * mass)
        found["J12"] = float(np.abs(response.stroke[dampers]).max() / bare.peak_displacement.max())
    return found


def _members(response: Response, bare: Response) -> list[int]:
    """The sites of ``response`` that are elements of the storeys: of each that ``bare`` has, the first one at its place."""
    free = [k for k, unit in enumerate(response.input_units) if unit == NO_INPUT]
    members = []
    for place in bare.sites:
        found = next((k for k in free if response.sites[k] == place), None)
        if found is None:
            raise InputError(
                f"bare has an element in {place} and the response with dampers none; give it elements | {{...}}, as bare had"
            )
        free.remove(found)
        members.append(found)
    return members


def _relative_to(size: Array, *responses: Response) -> tuple[list[float], list[float]]:
    """Of each response the largest drift over ``size`` (m, of all storeys or each), and the largest norm."""
    return (
        [float(np.max(r.peak_drift / size)) for r in responses],
        [_norm((r.drift.T / size).T) for r in responses],
    )


def _of_yielding(response: Response, bare: Response, members: list[int], yield_drifts: Array) -> dict[str, float]:
    largest, norms = _relative_to(yield_drifts, response, bare)
    found = {"J7": largest[0] / largest[1]}
    yielded = [int(np.sum(r.peak_drift > yield_drifts)) for r in (response, bare)]
    if yielded[1]:
        # what an element holds elastically at the end counts too, as a share of yield that is small where storeys have yielded
        taken = [r.energy.dampers[sites, -1].max() for r, sites in ((response, members), (bare, slice(None)))]
        found |= {"J8": float(taken[0] / taken[1]), "J9": yielded[0] / yielded[1]}
    return found | {"J10": norms[0] / norms[1]}


def _norm(histories: Array) -> float:
    """The largest root mean square of the rows."""
    return float(np.sqrt(np.mean(histories**2, axis=1)).max())
