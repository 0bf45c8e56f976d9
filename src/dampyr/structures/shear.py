"""Shear buildings: a mass per floor, a spring per storey; with one floor, the single mass of the textbooks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.structures.building import Building
from dampyr.structures.damping import modal, rayleigh
from dampyr.units import in_si

Array = NDArray[np.float64]


def shear_building(
    masses: ArrayLike,
    stiffnesses: ArrayLike,
    damping_ratio: float | Sequence[float] | None = None,
    dashpots: ArrayLike | None = None,
    method: str = "rayleigh",
    name: str = "shear building",
    modes: tuple[int, int] = (1, 2),
) -> Building:
    r"""A building with a mass per floor and a spring per storey, from the ground up.

    Parameters
    ----------
    masses, stiffnesses
        ``(n,)`` in kg and N/m, or quantities such as ``"0.4 t"``, greater than 0: of each floor, and of the storey below it.
    damping_ratio
        Of critical, from 0 to below 1 (0.02 is 2 %). With ``method="rayleigh"``, :math:`C = \alpha M + \beta K`, of two modes,
        one ratio for both or a pair; with ``method="modal"`` of every mode, one for all or n of them by rising frequency.
    dashpots
        ``(n,)`` in N s/m, one per storey, instead of a ratio. Give one of the two.
    method
        "rayleigh" or "modal": how the ratios make a damping matrix.
    name
        What the building is called.
    modes
        The two modes of ``"rayleigh"``, counted from 1 by rising frequency.

    Raises
    ------
    InputError
        Numbers do not match, or a pair of ratios would give some mode a negative one.

    Examples
    --------
    >>> import dampyr as dp
    >>> building = dp.structures.shear_building([2e4, 2e4], [3e7, 2e7], damping_ratio=0.02)
    >>> building.frequencies.round(2)
    array([3.56, 8.72])
    """
    mass, spring = positive("masses", masses, "kg"), positive("stiffnesses", stiffnesses, "N/m")
    if len(mass) != len(spring):
        raise InputError(f"{len(mass)} masses and {len(spring)} stiffnesses do not match; give one of each per storey")
    M, K = np.diag(mass), storey_matrix(spring)
    if damping_ratio is None and dashpots is not None:
        return Building(M, storey_matrix(_dashpots(dashpots, len(mass))), K, name)
    if damping_ratio is None or dashpots is not None:
        raise InputError("a shear building takes either damping_ratio= or dashpots=; give one of the two")
    if method not in ("rayleigh", "modal"):
        raise InputError(f"damping method {method!r} is not known; choose 'rayleigh' or 'modal'")
    C = rayleigh(M, K, damping_ratio, modes) if method == "rayleigh" else modal(M, K, damping_ratio)
    return Building(M, C, K, name)


def single_mass(
    mass: float,
    frequency: float | None = None,
    stiffness: float | None = None,
    damping_ratio: float = 0.0,
    name: str = "single mass",
) -> Building:
    r"""One mass on one spring: :math:`\ddot q + 2\zeta\omega\dot q + \omega^2 q = -a_g`.

    Parameters
    ----------
    mass
        kg, or a quantity such as ``"1 t"``, greater than 0.
    frequency, stiffness
        The natural frequency in Hz, or the stiffness in N/m; either may be a quantity. Give one of the two.
    damping_ratio
        Of critical, from 0 to below 1 (0.05 is 5 %); by default none.
    name
        What the building is called.

    Raises
    ------
    InputError
        A number is not allowed, or both or neither of frequency and stiffness are given.

    Examples
    --------
    >>> import dampyr as dp
    >>> tower = dp.structures.single_mass(2e4, frequency=1.5, damping_ratio=0.05)
    >>> tower.frequencies.round(2)
    array([1.5])
    """
    if (frequency is None) == (stiffness is None):
        raise InputError("a single mass takes either frequency= in Hz or stiffness= in N/m; give one of the two")
    if stiffness is None:
        omega = 2 * np.pi * positive("frequency", frequency, "Hz")
        stiffness = float(positive("mass", mass, "kg")[0] * omega[0] ** 2)
    return shear_building([mass], [stiffness], damping_ratio=damping_ratio, name=name)


def _dashpots(values: ArrayLike, count: int) -> Array:
    dashpots = np.asarray(in_si(values, "N s/m", "dashpots"), dtype=float)
    if dashpots.shape != (count,) or not np.all(np.isfinite(dashpots)) or dashpots.min() < 0:
        raise InputError(
            f"dashpots = {dashpots.tolist()} must be {count} finite numbers of at least 0 N s/m, one per storey"
        )
    return dashpots


def storey_matrix(values: Array) -> Array:
    """The matrix of one element per storey: its drift times its value, at both of its floors."""
    n = len(values)
    drift = np.eye(n) - np.eye(n, k=-1)
    return drift.T @ np.diag(values) @ drift


def positive(name: str, values: Any, unit: str) -> Array:
    """Numbers in SI of what a caller gave, each greater than 0."""
    array = np.atleast_1d(np.asarray(in_si(values, unit, name), dtype=float))
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)) or array.min() <= 0:
        raise InputError(f"{name} = {array.tolist()} must be a list of finite numbers greater than 0, one per storey")
    return array
