"""What several laws sense of a building, and what they weigh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.structures.building import Building

Array = NDArray[np.float64]


def absolute(building: Building, row: Array) -> Array:
    """Factors (2n + 1,) that make the absolute velocity of a damper's upper floor of the state and the ground's velocity;
    positive where it lengthens the damper."""
    upper = int(np.flatnonzero(row)[-1])
    factors = np.zeros(2 * building.n + 1)
    factors[building.n + upper], factors[-1] = row[upper], row[upper] * building.carried[upper]
    return factors


def weighted(building: Building, weights: Sequence[float]) -> Array:
    """Q (2n, 2n): of the diagonal ``weights`` of the floors, or diag(K, M) where there are none."""
    n = building.n
    if not len(weights):
        energy = np.zeros((2 * n, 2 * n))
        energy[:n, :n], energy[n:, n:] = building.K, building.M
        return energy
    given, floors = np.asarray(weights, dtype=float), building.n_floors
    if given.shape != (2 * floors,) or not np.all(np.isfinite(given)) or given.min() < 0 or given.max() == 0:
        raise InputError(
            f"weights = {tuple(weights)} is not allowed for {building.name}; give {2 * floors} numbers of at least 0, "
            "displacements first, not all 0"
        )
    rest = np.zeros(n - floors)  # of coordinates that are no floors
    return np.diag(np.concatenate([given[:floors], rest, given[floors:], rest]))
