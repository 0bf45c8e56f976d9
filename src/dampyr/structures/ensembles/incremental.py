"""Incremental dynamic analysis: how the peak grows with the intensity of each motion ([VamvatsikosCornell2002]_).

Curves are not processed: where a stronger motion gives a smaller peak they bend back, and nothing is smoothed or sorted.

References
----------
.. [VamvatsikosCornell2002] D. Vamvatsikos and C. A. Cornell, "Incremental dynamic analysis", Earthquake Engineering and
   Structural Dynamics 31(3), 491-514, 2002.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.origin import NOT_STATED, Origin
from dampyr.shown import Shown
from dampyr.structures.ensembles.peak_limits import UNITS
from dampyr.structures.ensembles.store import dataset_of, origin_of
from dampyr.structures.time_history.peaks import INTENSITIES, PeakGroup, groups

Array = NDArray[np.float64]
LEVELS = 40  # of intensity at which fractiles are taken: a smooth line in a figure
BEYOND = 1e300  # stands for infinity while fractiles are interpolated


@dataclass(frozen=True, eq=False, repr=False)
class IncrementalCurves(Shown):
    """The curves of one group: ``peaks`` (curves, scales) over ``intensity`` (curves, scales), by rising intensity; NaN where a
    case grew without bound. ``fractiles`` (fractions, levels) of the peaks at each of ``levels``, inf where so many of the
    cases grew without bound; levels are those that every motion reaches."""

    name: str
    intensity: Array
    peaks: Array
    levels: Array
    fractiles: Array

    @property
    def bent_back(self) -> int:
        """How many curves have a smaller peak somewhere at a greater intensity."""
        return int((np.diff(self.peaks, axis=1) < 0).any(axis=1).sum())

    @property
    def unbounded(self) -> int:
        """How many cases grew without bound."""
        return int(np.isnan(self.peaks).sum())


@dataclass(frozen=True, eq=False, repr=False)
class Incremental(Shown):
    """Sweeps of one quantity over one intensity; ``fractions`` such as 0.16, 0.5, 0.84."""

    sweeps: tuple[IncrementalCurves, ...]
    quantity: str
    quantity_unit: str
    intensity: str
    unit: str
    fractions: tuple[float, ...]
    origin: Origin = NOT_STATED

    def __getitem__(self, name: str) -> IncrementalCurves:
        for sweep in self.sweeps:
            if sweep.name == name:
                return sweep
        raise InputError(f"there is no sweep {name!r}; choose from {', '.join(s.name for s in self.sweeps)}")


def incremental(
    dataset: Any,
    quantity: str = "drift",
    intensity: str | ArrayLike = "pga",
    *,
    storey: str | int = "worst",
    height: ArrayLike | None = None,
    by: str | Sequence[str] = ("building", "input"),
    fractions: Sequence[float] = (0.16, 0.5, 0.84),
) -> Incremental:
    """Peaks over intensity for each motion of an ensemble (and each draw of the damper), with fractiles by intensity.

    Where motions have different intensities at the same scale, the fractiles are taken at 40 levels that all of them reach,
    each curve linear between its scales.

    Parameters
    ----------
    dataset, quantity, intensity, storey, height, by
        As in `fragility`.
    fractions
        The fractiles, each between 0 and 1; by default the median and one standard deviation to each side.

    Raises
    ------
    InputError
        The ensemble has fewer than two scales, or an argument is wrong.

    Examples
    --------
    >>> import dampyr as dp
    >>> motions = [dp.ground_motions.kanai_tajimi(5.0, 0.01, seed=(7, k), pga=3.0) for k in range(1, 4)]
    >>> peaks = dp.structures.ensemble(dp.structures.two_storey(), motions, scales=[0.5, 1.0, 2.0])
    >>> curves = dp.structures.incremental(peaks).sweeps
    >>> [(curve.name, curve.peaks.shape) for curve in curves]
    [('no damper', (3, 3))]
    """
    dataset = dataset_of(dataset)
    if dataset.sizes["scale"] < 2:
        raise InputError(
            "this ensemble has one scale; an incremental analysis needs several, such as scales=np.linspace(...)"
        )
    requested = tuple(float(p) for p in fractions)
    if not requested or not all(0 < p < 1 for p in requested):
        raise InputError(f"fractions = {tuple(fractions)} is not allowed; each must lie between 0 and 1, as in 0.5")
    case_groups = groups(dataset, quantity, storey, intensity, by, height)
    named = intensity if isinstance(intensity, str) else "your measure"
    return Incremental(
        tuple(_sweep(group, requested) for group in case_groups),
        quantity,
        "" if height is not None else UNITS[quantity],
        named,
        INTENSITIES.get(named, ""),
        requested,
        origin_of(dataset),
    )


def _sweep(group: PeakGroup, fractions: tuple[float, ...]) -> IncrementalCurves:
    x, peaks = group.by_rising_intensity()
    intensity = np.broadcast_to(x, peaks.shape).reshape(-1, x.shape[1])
    peaks = peaks.reshape(intensity.shape)
    if np.all(x == x[:1]):
        levels, at = x[0], peaks
    else:
        low, high = x[:, 0].max(), x[:, -1].min()
        levels = np.linspace(low, high, LEVELS) if high > low else np.zeros(0)
        at = np.array([_between(levels, a, b) for a, b in zip(intensity, peaks)])
    # a case that grew without bound is the largest of all, and a fractile beyond it is infinite
    quantiles = np.quantile(np.where(np.isnan(at), BEYOND, at), fractions, axis=0)
    fractiles = np.where(quantiles > BEYOND * 1e-6, np.inf, quantiles)
    return IncrementalCurves(group.name, intensity, peaks, levels, fractiles)


def _between(levels: Array, x: Array, peaks: Array) -> Array:
    """Linear between the scales; NaN next to a case that grew without bound, but not at a scale that did not."""
    interpolated = np.interp(levels, x, peaks)
    exact = np.searchsorted(x, levels)
    nearest = np.minimum(exact, len(x) - 1)
    return np.where(x[nearest] == levels, peaks[nearest], interpolated)
