r"""Criteria of benchmark control problems: what a controlled response is beside that without dampers, as ratios.

With d the storey drifts over their heights, :math:`\ddot x_a` the absolute accelerations, V the base shear, f and y force and
stroke of the dampers, x the displacements relative to the ground, W the building's weight, subscript u the response without
dampers, and :math:`\|s\| = \sqrt{\tfrac1T \int s^2 dt}`:

.. math:: J_1 = \frac{\max |d|}{\max |d_u|}, \quad J_2 = \frac{\max |\ddot x_a|}{\max |\ddot x_{a,u}|}, \quad
          J_3 = \frac{\max |V|}{\max |V_u|}, \quad J_4, J_5, J_6 \text{ the same of } \|\cdot\|, \quad
          J_{11} = \frac{\max |f|}{W}, \quad J_{12} = \frac{\max |y|}{\max |x_u|}

:math:`J_7` to :math:`J_{10}` are of members that yield, :math:`J_{13}` and :math:`J_{14}` of the power that the dampers take,
which no card states, and :math:`J_{15}` to :math:`J_{17}` count devices, sensors and the controller's states.

Reference: Y. Ohtori, R. E. Christenson, B. F. Spencer and S. J. Dyke, Benchmark control problems for seismically excited
nonlinear buildings, Journal of Engineering Mechanics 130 (2004) 366-385.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.structures.building import Building
from dampyr.structures.time_history.peaks import storey_heights
from dampyr.structures.time_history.response import Response
from dampyr.units import STANDARD_GRAVITY

Array = NDArray[np.float64]


def benchmark_criteria(
    response: Response, bare: Response, building: Building, height: ArrayLike = 1.0
) -> dict[str, float]:
    """Criteria J1 to J6, J11 and J12 of a response with dampers, by their names: ratios, 1 without control for the first six.

    Parameters
    ----------
    response, bare
        What `respond` gave for the same building and motion, with dampers and without.
    building
        The building, whose weight J11 is over.
    height
        m, of all storeys or one each; where all are equal it does not matter.

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
    if bare.sites:
        raise InputError("bare has dampers; give the response of the building without any")
    heights = storey_heights(height, building.n_floors)
    scale = (1.0 / heights if heights.ndim else np.full(building.n_floors, 1.0 / heights))[:, None]
    drifts = [scale * r.drift for r in (response, bare)]
    largest = [float(np.max(scale[:, 0] * r.peak_drift)) for r in (response, bare)]
    found = {
        "J1": largest[0] / largest[1],
        "J2": float(response.peak_acceleration.max() / bare.peak_acceleration.max()),
        "J3": response.peak_base_shear / bare.peak_base_shear,
        "J4": _norm(drifts[0]) / _norm(drifts[1]),
        "J5": _norm(response.acceleration) / _norm(bare.acceleration),
        "J6": _norm(response.base_shear[None]) / _norm(bare.base_shear[None]),
    }
    if response.sites:
        # the mass that follows the ground, all of it where the structure is a reduced one
        mass = float(building.influence @ building.M @ building.carried) + building.ground_terms()[1]
        found["J11"] = float(response.peak_force.max()) / (STANDARD_GRAVITY * mass)
        found["J12"] = float(np.abs(response.stroke).max() / bare.peak_displacement.max())
    return found


def _norm(histories: Array) -> float:
    """The largest root mean square of the rows."""
    return float(np.sqrt(np.mean(histories**2, axis=1)).max())
