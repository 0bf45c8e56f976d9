"""Capacities: the intensity at which each motion first exceeds a limit, where its scales reach that far."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.structures.peaks import Group

Array = NDArray[np.float64]
REACHED, RIGHT_CENSORED, LEFT_CENSORED = 0, 1, -1


@dataclass(frozen=True, eq=False)
class Capacities:
    """One for each case of a motion, (pooled, motion): ``value`` known where ``kind`` is 0; +1 says that the limit was not
    exceeded up to ``value``, the strongest scale, -1 that it was exceeded at ``value``, the weakest, already."""

    value: Array
    kind: Array

    @property
    def observed(self) -> int:
        """How many lie inside the scales."""
        return int((self.kind == REACHED).sum())

    @property
    def above(self) -> int:
        """How many never exceeded the limit."""
        return int((self.kind == RIGHT_CENSORED).sum())

    @property
    def below(self) -> int:
        """How many exceeded it at the weakest scale already."""
        return int((self.kind == LEFT_CENSORED).sum())

    def points(self) -> tuple[Array, Array, Array]:
        """Values, kinds and weights 1, as rows."""
        return self.value.ravel(), self.kind.ravel(), np.ones(self.value.size)


def capacities(group: Group, limit: float) -> Capacities:
    """First exceedances, by rising intensity: between the last scale that held and the first that exceeded the peak is taken
    as linear; where the latter grew without bound, their geometric mean is taken. Later returns below the limit do not count.
    """
    order = np.argsort(group.intensity, axis=1, kind="stable")
    x = np.take_along_axis(group.intensity, order, axis=1)[None]
    peaks = np.take_along_axis(group.peaks, np.broadcast_to(order, group.peaks.shape), axis=2)
    exceeds = np.isnan(peaks) | (peaks > limit)
    first = np.argmax(exceeds, axis=2)
    ever = exceeds.any(axis=2)
    kind = np.select([~ever, first == 0], [RIGHT_CENSORED, LEFT_CENSORED], REACHED)
    before = np.maximum(first - 1, 0)
    x0, x1 = (np.take_along_axis(np.broadcast_to(x, peaks.shape), k[..., None], 2)[..., 0] for k in (before, first))
    p0, p1 = (np.take_along_axis(peaks, k[..., None], 2)[..., 0] for k in (before, first))
    with np.errstate(invalid="ignore", divide="ignore"):
        inside = np.where(np.isnan(p1), np.sqrt(x0 * x1), x0 + (x1 - x0) * (limit - p0) / (p1 - p0))
    value = np.select(
        [kind == RIGHT_CENSORED, kind == LEFT_CENSORED], [np.broadcast_to(x[..., -1], kind.shape), x1], inside
    )
    return Capacities(value, kind)
