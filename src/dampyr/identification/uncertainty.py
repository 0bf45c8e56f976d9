r"""How well the coefficients are known.

Residuals of a hysteresis model are correlated over whole cycles, so the textbook error :math:`s^2 (J^T J)^{-1}` (the *naive*
one) is far too small. The errors given here are the sandwich

.. math:: (J^T J)^{-1} \Big(\sum_g J_g^T r_g\, r_g^T J_g\Big) (J^T J)^{-1} \frac{G}{G-1}

over clusters g that are independent of one another: the records in a joint fit, the cycles where there are fewer than
`FEWEST_RECORDS` records to a coefficient. J is what is left of the derivatives after each record's nuisances have taken
their part, and G the effective number of clusters. A direction that the records do not determine has an infinite error, not
a small one.

Liang and Zeger (1986); Cameron and Miller (2015).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.pieces import linearise
from dampyr.identification.solver import Point, Problem, expand

Array = NDArray[np.float64]
FEWEST_RECORDS = 5
FEWEST_CYCLES = 3
BLIND = 1e-7
TINY = 1e-100


@dataclass(frozen=True)
class Uncertainty:
    """Covariances (m, m) of the coefficients; what they were clustered by; how many clusters speak of each coefficient, and the
    degrees of freedom that makes (fewer where a few clusters say most of it)."""

    covariance: Array
    naive: Array
    clusters: str
    counts: Array
    freedom: Array
    blind: tuple[int, ...]


def uncertainty(problem: Problem, point: Point, held: tuple[int, ...] = ()) -> Uncertainty:
    """The covariance of the coefficients at the optimum; those ``held`` at a limit count as known."""
    theta = point.of(problem)
    reduced, samples = [], 0
    for one, start in zip(problem.pieces, point.starts, strict=True):
        local = linearise(problem.composition, problem.columns, theta, one, start, problem.offset)
        J = _without(expand(problem, local.by_parameter, one.u), local.by_nuisance)
        J[:, list(held)] = 0.0
        reduced.append((J, local.residual, one.cycle))
        samples += one.t.size - local.by_nuisance.shape[1]
    information = sum((J.T @ J for J, _, _ in reduced), np.zeros((problem.size,) * 2))
    bread, blind = _inverse(information, held)
    squares = sum(float(r @ r) for _, r, _ in reduced)
    naive = bread * squares / max(samples - problem.size, 1)
    scores, counts, freedom = _scores_by_record(reduced, information)
    clusters = "record"
    if np.any(np.delete(counts, [*held, *blind]) < FEWEST_RECORDS):
        clusters = "cycle"
        scores, counts, freedom = _scores_by_cycle(reduced, information)
    covariance = _sandwich(bread, scores, freedom)
    blind = tuple(sorted({*blind, *(k for k in map(int, np.flatnonzero(counts < FEWEST_CYCLES)) if k not in held)}))
    return Uncertainty(_blinded(covariance, blind), _blinded(naive, blind), clusters, counts, freedom, blind)


def _without(J: Array, nuisance: Array) -> Array:
    """What is left of the columns of J after projecting out the nuisances."""
    if nuisance.shape[1] == 0:
        return J.copy()
    q, r = np.linalg.qr(nuisance)
    q = q[:, np.abs(np.diag(r)) > 1e-12 * max(float(np.abs(r).max()), 1e-300)]
    return np.asarray(J - q @ (q.T @ J))


def _inverse(information: Array, held: tuple[int, ...]) -> tuple[Array, tuple[int, ...]]:
    """The inverse on what is determined, and the coefficients that take part in a direction that is not."""
    scale = np.sqrt(np.diag(information))
    free = scale > 1e-12 * max(float(scale.max(initial=0.0)), 1e-300)
    unit = np.where(free, 1.0 / np.where(free, scale, 1.0), 0.0)
    values, vectors = np.linalg.eigh(information * np.outer(unit, unit))
    known = values > BLIND**1.5 * max(float(values.max(initial=0.0)), 1e-300)
    inverse = (vectors[:, known] / values[known]) @ vectors[:, known].T * np.outer(unit, unit)
    lost = np.abs(vectors[:, ~known & (values > -np.inf)]) > 1e-3
    blind = {int(k) for k in np.flatnonzero(~free | (lost.any(axis=1) & free)) if k not in held}
    return inverse, tuple(sorted(blind))


Reduced = list[tuple[Array, Array, NDArray[np.int64]]]


def _scores_by_record(reduced: Reduced, information: Array) -> tuple[Array, Array, Array]:
    return _counted([(J.T @ r, J) for J, r, _ in reduced], information)


def _scores_by_cycle(reduced: Reduced, information: Array) -> tuple[Array, Array, Array]:
    parts = []
    for J, r, cycle in reduced:
        for k in np.unique(cycle):
            here = cycle == k
            parts.append((J[here].T @ r[here], J[here]))
    return _counted(parts, information)


def _counted(parts: list[tuple[Array, Array]], information: Array) -> tuple[Array, Array, Array]:
    """The scores (G, m), how many clusters speak of each coefficient, and its degrees of freedom.

    These are one less than the effective number of clusters, 1 / sum of the squared shares of the information: G equal
    clusters count as G, and one that says all counts as one.
    """
    scores = np.array([score for score, _ in parts])
    told = np.array([np.einsum("ij,ij->j", J, J) for _, J in parts])
    total = np.diag(information)
    shares = np.where(total > TINY, told / np.where(total > TINY, total, 1.0), 0.0)
    effective = 1.0 / np.maximum(np.sum(shares**2, axis=0), TINY)
    return scores, np.sum(shares > 1e-3, axis=0), np.maximum(np.minimum(effective, len(parts)), 1.5) - 1.0


def _sandwich(bread: Array, scores: Array, freedom: Array) -> Array:
    influence = (scores @ bread) * np.sqrt((freedom + 1.0) / freedom)
    return np.asarray(influence.T @ influence)


def _blinded(covariance: Array, blind: tuple[int, ...]) -> Array:
    out = covariance.copy()
    for k in blind:
        out[k, :] = out[:, k] = 0.0
        out[k, k] = np.inf
    return out
