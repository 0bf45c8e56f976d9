r"""The residual by the direction of the motion: out (the damper is pulled, v > 0) and in (it is pushed, v < 0).

Each way is halved where the motion passes the middle of its stroke: before it the damper speeds up, beyond it it slows down.
The middle is a straight line through the displacement, so that a drift moves no boundary. Samples slower than `SLOW` of the
record's greatest speed belong to no side.

A model that is the same in both directions has a residual :math:`m(v)` that changes its sign with the mirrored motion. Its
even part :math:`e(v) = (m(v) + m(-v))/2`, of the medians binned over velocity before and beyond the middle, less the mean
that each record's offset takes, is what such a model cannot follow; **unevenness** is its rms over the samples in N. By chance
alone its share of the residual's variance is at most about b/n for b bins and n effective samples. The damper may be the
cause, or a motion that is not alike in both directions. A friction that differs between the directions is an offset, and no
analysis of these residuals can see it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from dampyr.identification.residuals import Trace

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
SLOW = 0.02
BINS = 24
MIN_BIN_SAMPLES = 10
BRANCHES = ("before the middle", "beyond the middle")
SIDES = ("out", "in", *(f"{way}, {branch}" for way in ("out", "in") for branch in BRANCHES))


@dataclass(frozen=True)
class Side:
    """The samples that move one way: how many, mean and rms of their residual in N (NaN without samples)."""

    samples: int
    mean: float
    rms: float


@dataclass(frozen=True)
class Curve:
    """Median and quartiles of the residual in N over `BINS` bins of velocity (centres in m/s, alike on both sides of zero).

    NaN in bins of fewer than `FEWEST_IN_BIN` samples; ``counts`` says how many there are.
    """

    velocity: Array
    lower: Array
    median: Array
    upper: Array
    counts: NDArray[np.int64]


@dataclass(frozen=True)
class Group:
    """The records at one input, or all of them (``input_value`` None).

    ``rms`` and ``unevenness`` in N; ``chance`` is the share of the variance
    that the latter may have by chance; ``sides``
    by `SIDES`, ``curves`` by `BRANCHES`.
    """

    input_value: float | None
    records: tuple[str, ...]
    rms: float
    sides: dict[str, Side]
    curves: dict[str, Curve]
    unevenness: float
    chance: float


def group(traces: Sequence[Trace], effective: float, input_value: float | None = None) -> Group:
    """The residuals of some records by direction; ``effective`` samples are what they speak like."""
    r = np.concatenate([one.residual for one in traces])
    v = np.concatenate([one.velocity for one in traces])
    masks = [_masks(one) for one in traces]
    joined = {name: np.concatenate([mask[name] for mask in masks]) for name in SIDES}
    reach = float(np.max(np.abs(v)))
    curves = {}
    for branch in BRANCHES:
        here = joined[f"out, {branch}"] | joined[f"in, {branch}"]
        curves[branch] = _curve(v[here], r[here], reach)
    return Group(
        input_value=input_value,
        records=tuple(one.name for one in traces),
        rms=_rms(r),
        sides={name: _side(r[mask]) for name, mask in joined.items()},
        curves=curves,
        unevenness=_unevenness(list(curves.values())),
        chance=BINS / effective,
    )


def _masks(one: Trace) -> dict[str, Mask]:
    """Which samples belong to each of `SIDES`."""
    fast = np.abs(one.velocity) > SLOW * float(np.max(np.abs(one.velocity)))
    t = one.time - one.time.mean()
    middle = one.displacement.mean() + t * float(t @ one.displacement) / float(t @ t)
    out, back, above = fast & (one.velocity > 0.0), fast & (one.velocity < 0.0), one.displacement > middle
    return dict(zip(SIDES, (out, back, out & ~above, out & above, back & above, back & ~above), strict=True))


def _side(r: Array) -> Side:
    if r.size == 0:
        return Side(0, float("nan"), float("nan"))
    return Side(r.size, float(np.mean(r)), _rms(r))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _curve(v: Array, r: Array, reach: float) -> Curve:
    edges = np.linspace(-reach, reach, BINS + 1)
    number = np.clip(np.searchsorted(edges, v, side="right") - 1, 0, BINS - 1)
    quartiles = np.full((3, BINS), np.nan)
    counts = np.bincount(number, minlength=BINS)
    for k in np.flatnonzero(counts >= MIN_BIN_SAMPLES):
        quartiles[:, k] = np.quantile(r[number == k], (0.25, 0.5, 0.75))
    return Curve(0.5 * (edges[1:] + edges[:-1]), quartiles[0], quartiles[1], quartiles[2], counts)


def _unevenness(curves: Sequence[Curve]) -> float:
    """The rms of the medians' even part, weighted by the samples that both of its bins hold; 0 where there is none."""
    even = np.concatenate([0.5 * (c.median + c.median[::-1]) for c in curves])
    weights = np.concatenate([np.minimum(c.counts, c.counts[::-1]) for c in curves]).astype(float)
    finite = np.isfinite(even)
    if not np.any(weights[finite]):
        return 0.0
    even, weights = even[finite], weights[finite] / np.sum(weights[finite])
    return float(np.sqrt(weights @ (even - weights @ even) ** 2))
