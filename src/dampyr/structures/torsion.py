r"""Shear buildings whose floors turn in plan: frames at a distance, masses off the centre of stiffness, dampers on a line.

The ground moves in x. A floor is rigid in plan, with the mass m and the moment of inertia J about its centre of mass, which
lies at :math:`y_m`, and the frames of a storey, of the stiffness :math:`k_f` at :math:`y_f`, act on its displacement there,

.. math:: u(y) = u_m + (y - y_m)\, \theta, \qquad 2 T = m \dot u_m^2 + J \dot\theta^2, \qquad
          2 U = \sum_f k_f\, \big(u_i(y_f) - u_{i-1}(y_f)\big)^2 + k_\theta\, (\theta_i - \theta_{i-1})^2

:math:`k_\theta` is what frames across x add. The coordinates of a floor are its displacements on two lines, :math:`u(y_1)` and
:math:`u(y_2)`, of which those of any other line and the turn follow, :math:`\theta = (u(y_2) - u(y_1))/(y_2 - y_1)`. On
these two lines dampers stand as in any building, and their drifts are those of the building's edges. Motion across x and its
coupling are left out: the plan is symmetric about an axis along y.

Reference: A. K. Chopra, Dynamics of Structures (2017), section 9.5.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.structures.building import Building
from dampyr.structures.damping import modal, rayleigh
from dampyr.structures.shear import positive
from dampyr.units import in_si

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class TorsionalBuilding(Building):
    """A building whose floors turn, as `torsional_building` makes it: two coordinates a floor, its displacements at ``lines``
    (2,) [m]; ``centres`` [m] are where the centres of mass of its floors lie."""

    lines: tuple[float, float] = (0.0, 1.0)
    centres: Array = field(default_factory=lambda: np.zeros(0))

    def floor_below(self, storey: int) -> int:
        """See `Building.floor_below`: on each line a storey stands on the floor below."""
        return max(storey - 2, 0)

    def at(self, position: ArrayLike) -> Array:
        """The rows (floors, n) that turn motions of the coordinates into those of the floors at a position [m], one for all or
        one for each: ``building.at(y) @ response.displacement``."""
        first, second = self.lines
        share = (np.broadcast_to(np.asarray(position, dtype=float), (self.n // 2,)) - first) / (second - first)
        rows = np.zeros((self.n // 2, self.n))
        floors = np.arange(self.n // 2)
        rows[floors, 2 * floors], rows[floors, 2 * floors + 1] = 1.0 - share, share
        return rows

    @property
    def rotation(self) -> Array:
        """The rows (floors, n) that turn motions of the coordinates into the turns of the floors, rad, u rising with y."""
        first, second = self.lines
        return np.asarray(np.kron(np.eye(self.n // 2), [-1.0, 1.0]) / (second - first))

    def condensed(self, keep: Sequence[int | str]) -> Any:
        """Refused: what is kept would no longer be floors that turn."""
        raise InputError(f"{self.name} has floors that turn and cannot be condensed to {list(keep)}")


def torsional_building(
    masses: ArrayLike,
    inertias: ArrayLike,
    frames: Mapping[float, ArrayLike],
    centres: ArrayLike = 0.0,
    lines: Sequence[float] | None = None,
    torsional_stiffness: ArrayLike = 0.0,
    damping_ratio: float | Sequence[float] = 0.0,
    method: str = "modal",
    modes: tuple[int, int] = (1, 2),
    names: tuple[str, str] = ("left", "right"),
    name: str = "torsional building",
) -> TorsionalBuilding:
    """A shear building whose floors move in x and turn, from the ground up.

    Parameters
    ----------
    masses, inertias
        ``(n,)`` in kg and kg m2, greater than 0: of each floor, the inertia in plan about its centre of mass.
    frames
        Position y in m -> stiffness in N/m of the frame there, one for all storeys or ``(n,)``.
    centres
        y of the centres of mass, m, one for all floors or ``(n,)``.
    lines
        The two y, m, on which dampers stand and displacements are given; by default those of the outermost frames.
    torsional_stiffness
        N m/rad that frames across x add in each storey, one for all or ``(n,)``.
    damping_ratio, method, modes
        As in `shear_building`; modes by rising frequency, those that turn among them.
    names
        What the lines are called: the floors are "1 left", "1 right", "2 left" and so on.
    name
        What the building is called.

    A damper stands at ``{("1 left", "2 left"): damper}`` or, from the ground, ``{("ground", "1 right"): damper}``. Storeys
    count along both lines: 1 and 2 are the first one's left and right, 3 and 4 the second one's.

    Raises
    ------
    InputError
        A number is not allowed, or the floors can turn without a spring.

    Examples
    --------
    >>> import dampyr as dp
    >>> S, motion = dp.structures, dp.ground_motions.el_centro()
    >>> house = S.torsional_building([2e4], [4e5], {-5.0: 3e6, 5.0: 5e6}, damping_ratio=0.03)
    >>> response = S.respond(house, motion)
    >>> house.frequencies.round(2), (1e3 * response.peak_drift).round(1)
    (array([2.88, 3.81]), array([33.5, 15.4]))
    """
    mass, inertia = positive("masses", masses, "kg"), positive("inertias", inertias, "kg m^2")
    n = len(mass)
    if len(inertia) != n:
        raise InputError(f"{n} masses and {len(inertia)} inertias do not match; give one of each per floor")
    if not isinstance(frames, Mapping) or not frames:
        raise InputError(
            "frames must be a mapping from position in m to stiffness in N/m, such as {-5.0: 3e6, 5.0: 5e6}"
        )
    stiffness = {
        float(in_si(y, "m", "the position of a frame")): _of_floors(f"the frame at {y} m", k, n, "N/m", low=0.0)
        for y, k in frames.items()
    }
    where = (
        (min(stiffness), max(stiffness)) if lines is None else tuple(map(float, np.ravel(in_si(lines, "m", "lines"))))
    )
    if len(where) != 2 or not np.all(np.isfinite(where)) or where[0] == where[1]:
        more = "; a single frame does not say them" if lines is None else ""
        raise InputError(f"lines = {list(where)} is not allowed; give two different positions in m{more}")
    if len(set(names)) != 2:
        raise InputError(f"names = {names!r} must be two different names")
    across = _of_floors("torsional_stiffness", torsional_stiffness, n, "N m/rad", low=0.0)
    middle = _of_floors("centres", centres, n, "m")
    outline = TorsionalBuilding(
        np.eye(2 * n), np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n)), name,
        [f"{k + 1} {line}" for k in range(n) for line in names], lines=where, centres=middle,
    )  # fmt: skip
    drift = np.eye(n) - np.eye(n, k=-1)
    turn = outline.rotation
    M = outline.at(middle).T @ np.diag(mass) @ outline.at(middle) + turn.T @ np.diag(inertia) @ turn
    K = (drift @ turn).T @ np.diag(across) @ (drift @ turn)
    for y, k in stiffness.items():
        rows = drift @ outline.at(y)
        K = K + rows.T @ np.diag(k) @ rows
    values = np.linalg.eigvalsh(K)
    if values[0] <= 1e-12 * values[-1]:
        raise InputError(
            "the floors can move or turn without a spring; give every storey two frames, or one and a torsional_stiffness"
        )
    if method not in ("rayleigh", "modal"):
        raise InputError(f"damping method {method!r} is not known; choose 'rayleigh' or 'modal'")
    C = rayleigh(M, K, damping_ratio, modes) if method == "rayleigh" else modal(M, K, damping_ratio)
    M, C, K = (0.5 * (matrix + matrix.T) for matrix in (M, C, K))
    return TorsionalBuilding(M, C, K, name, outline.floors, lines=outline.lines, centres=middle)


def _of_floors(what: str, values: ArrayLike, count: int, unit: str, low: float = -np.inf) -> Array:
    """A number for each of the floors, of one or of so many."""
    array = np.atleast_1d(np.asarray(in_si(values, unit, what), dtype=float))
    if array.shape not in ((1,), (count,)) or not np.all(np.isfinite(array)) or np.any(array < low):
        least = f" of at least {low:g}" if np.isfinite(low) else ""
        raise InputError(
            f"{what} = {array.tolist()} is not allowed; give a finite number{least} in {unit}, or {count} of them"
        )
    return np.array(np.broadcast_to(array, count), dtype=np.float64)
