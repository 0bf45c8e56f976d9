"""Groups of an ensemble's cases for fragilities and incremental analyses: one peak a case.

One curve is drawn of each group. In it, a motion is the unit: its scales and the draws of the damper belong to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.structures.ensembles.store import ALONG, BARE, WITH_DAMPER

Array = NDArray[np.float64]
DIMS = ("building", "damper", "input")
SAME_LEVEL = 1e-9  # of an intensity: nearer ones are one level
INTENSITIES = {"pga": "m/s^2", "sa": "m/s^2", "scale": ""}


@dataclass(frozen=True, eq=False)
class PeakGroup:
    """The cases of one curve: ``peaks`` (pooled, motion, scale), NaN for a case that grew without bound."""

    name: str
    peaks: Array
    intensity: Array  # (motion, scale)

    def by_rising_intensity(self) -> tuple[Array, Array]:
        """The intensities (motion, scale) and the peaks, the scales of every motion in the order of its intensity."""
        order = np.argsort(self.intensity, axis=1, kind="stable")
        peaks = np.take_along_axis(self.peaks, np.broadcast_to(order, self.peaks.shape), axis=2)
        return np.take_along_axis(self.intensity, order, axis=1), peaks


def groups(
    dataset: Any,
    quantity: str,
    storey: str | int,
    intensity: str | ArrayLike,
    by: str | Sequence[str],
    height: ArrayLike | None = None,
) -> list[PeakGroup]:
    """One group for every entry along the dims ``by``; along the other dims cases are pooled, but never a bare building with
    one that has a damper: the bare one is a group of its own, once."""
    by = (by,) if isinstance(by, str) else tuple(by)
    wrong = [dim for dim in by if dim not in DIMS]
    if wrong:
        raise InputError(f"by = {wrong[0]!r} is not known; choose from {', '.join(DIMS)}")
    worst = peak_of_cases(dataset, quantity, storey, height)
    strength = intensities(dataset, intensity)
    names = np.asarray(dataset.damper_name.values).astype(str)
    bare, fitted = np.flatnonzero(names == BARE), np.flatnonzero(names != BARE)
    if ALONG[quantity] == "site":
        bare = bare[:0]  # no damper has no force
    result: list[PeakGroup] = []
    for b in _split(dataset, "building", by):
        if bare.size:
            result.append(
                PeakGroup(_name(dataset, by, b, None, None), _pooled(worst, b, bare[:1], [0]), strength[b[0]])
            )
        for d in [[k] for k in fitted] if "damper" in by else [fitted] if fitted.size else []:
            for u in _split(dataset, "input", by):
                result.append(PeakGroup(_name(dataset, by, b, d, u), _pooled(worst, b, d, u), strength[b[0]]))
    _check_pooled_intensities(strength, by)
    return result


def _split(dataset: Any, dim: str, by: Sequence[str]) -> list[list[int]]:
    n = dataset.sizes[dim]
    return [[k] for k in range(n)] if dim in by else [list(range(n))]


def _pooled(worst: Array, b: Any, d: Any, u: Any) -> Array:
    cut = worst[np.ix_(b, d, u)]
    return cut.reshape(-1, *cut.shape[3:])


def _name(dataset: Any, by: Sequence[str], b: list[int], d: Any, u: Any) -> str:
    parts = [str(dataset.building_name.values[b[0]])] if "building" in by and dataset.sizes["building"] > 1 else []
    if d is None:
        return ", ".join([*parts, BARE])
    if "damper" in by and np.sum(np.asarray(dataset.damper_name.values).astype(str) != BARE) > 1:
        parts.append(str(dataset.damper_name.values[d[0]]))
    if "input" in by and (name := str(dataset.input_name.values[u[0]])):
        parts.append(name)
    return ", ".join(parts) or ("all cases" if dataset.input.attrs.get("units") else WITH_DAMPER)


def _check_pooled_intensities(strength: Array, by: Sequence[str]) -> None:
    if "building" not in by and not np.array_equal(
        strength, np.broadcast_to(strength[:1], strength.shape), equal_nan=True
    ):
        raise InputError(
            'intensity "sa" is that at each building\'s own period, so buildings cannot be pooled; '
            'write by=("building", ...) or another intensity'
        )


def intensities(dataset: Any, intensity: str | ArrayLike) -> Array:
    """How strong each motion is at each scale, (building, motion, scale); see `fragility` for ``intensity``."""
    shape = (dataset.sizes["building"], dataset.sizes["motion"])
    factor = np.abs(dataset.scale.values)
    if isinstance(intensity, str):
        if intensity not in INTENSITIES:
            raise InputError(
                f"intensity = {intensity!r} is not known; choose from {', '.join(INTENSITIES)}, or give one number a motion"
            )
        unscaled = np.ones(shape) if intensity == "scale" else np.broadcast_to(dataset[intensity].values, shape)
    else:
        measures = np.asarray(intensity, dtype=float)
        if measures.shape != shape[1:]:
            raise InputError(
                f"intensity has shape {measures.shape}; give one number for each of the {shape[1]} motions"
            )
        unscaled = np.broadcast_to(measures, shape)
    bad = np.argwhere(~(np.isfinite(unscaled) & (unscaled > 0)))
    if bad.size or not np.all(factor > 0):
        raise InputError(
            f"the intensity of motion {bad[0][1] + 1} is {unscaled[tuple(bad[0])]:g}; it must be greater than 0"
            if bad.size
            else "a scale of 0 has no intensity; leave it out"
        )
    return _merge_levels(unscaled[:, :, None] * factor)


def _merge_levels(intensity: Array) -> Array:
    """The same intensities with one value where they differ by rounding only.

    Motions scaled to one peak do so on one machine and not on another, and a curve may hang on which of them is greater."""
    sizes, place = np.unique(intensity, return_inverse=True)
    begins = np.diff(sizes, prepend=-np.inf) > SAME_LEVEL * sizes
    level: Array = sizes[begins][np.cumsum(begins) - 1][place]
    return level.reshape(intensity.shape)


def peak_of_cases(dataset: Any, quantity: str, storey: str | int, height: ArrayLike | None) -> Array:
    """The peak of each case (building, damper, input, motion, scale): of one storey, or of the worst."""
    if quantity not in dataset:
        raise InputError(
            f"quantity = {quantity!r} is not in this ensemble; it has {', '.join(map(str, dataset.data_vars))}"
        )
    values = np.asarray(dataset[quantity].values, dtype=float)
    if height is not None:
        if quantity != "drift":
            raise InputError(f"height= turns a drift into a ratio; with {quantity} leave it out")
        values = values / storey_heights(height, values.shape[-1])
    if storey == "worst":
        if not values.shape[-1]:
            raise InputError(f"no case has a {quantity}; take another quantity")
        lost = np.isnan(values).all(axis=-1)
        return np.where(lost, np.nan, np.where(np.isnan(values), -np.inf, values).max(axis=-1))
    if isinstance(storey, str) or not 1 <= storey <= values.shape[-1]:
        raise InputError(f"storey = {storey!r} does not exist; write 'worst' or count from 1 to {values.shape[-1]}")
    chosen = values[..., storey - 1]
    other = np.isfinite(values).any(axis=-1) & np.isnan(chosen)
    if other.any():
        where = dataset.building_name.values[int(np.argwhere(other)[0][0])]
        raise InputError(
            f"{where} has no {quantity} at {storey}; write storey='worst', or take the other buildings alone"
        )
    return chosen


def storey_heights(height: ArrayLike, storeys: int) -> Array:
    """The height of every storey, m, given for all or one each; InputError where it is not above 0."""
    heights = np.asarray(height, dtype=float)
    if heights.shape not in ((), (storeys,)) or not np.all(heights > 0):
        raise InputError(
            f"height = {height!r} m is not allowed; give one, or one for each of {storeys} storeys, above 0"
        )
    return heights
