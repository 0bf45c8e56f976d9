r"""Standard errors and covariance of the coefficients.

Residuals of a hysteresis model are correlated over whole cycles, so the textbook error :math:`s^2 (J^T J)^{-1}` (the *naive*
one) is far too small. The errors given here are the sandwich

.. math:: (J^T J)^{-1} \Big(\sum_g J_g^T r_g\, r_g^T J_g\Big) (J^T J)^{-1} \frac{G}{G-1}

over clusters g that are independent of one another: the records, the pieces of one that was cut together. How many degrees
of freedom it has depends on how records differ: where each has noise of its own, the effective number of records less one;
where each has a gain of its own, those of Satterthwaite (1946) for that, which are fewer. Records do both, and the mean of
the two is taken. A coefficient that fewer than `MIN_RECORDS` records determine has an error by cycles: it holds within
these records only and gives no interval. J is what is left of the derivatives after each record's nuisances have taken
their part, and G the effective number of clusters. A direction that the records do not determine has an infinite error, not
a small one.

Liang and Zeger (1986); Cameron and Miller (2015); Bell and McCaffrey (2002) for the degrees of freedom under a model of how
clusters differ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem
from dampyr.models.prediction_error import force_power

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
MIN_RECORDS = 3  # with two, t with one degree of freedom takes 12.7 errors for 95 %
MIN_CYCLES = 3  # for an error by cycles at all
UNDETERMINED = 1e-7  # to the power 1.5, of the largest eigenvalue: well above the rounding of sums of products
TINY = 1e-100  # instead of zero in a division
SAME = 1e-13  # of the sums of squares: what is left below it is rounding


@dataclass(frozen=True)
class Uncertainty:
    """Covariances (m, m) of the coefficients, and what they rest on.

    ``counts`` is how many clusters determine each coefficient, ``freedom`` its degrees of freedom (fewer where a few
    clusters hold most of the information, and where records differ by their gains). The records do not determine the
    ``unidentifiable`` ones, and too ``few`` cycles determine others. ``records`` is how many records determine each,
    ``within`` where these are too few to be the clusters, so that cycles are.

    ``by_level`` (R, m) is the change of the coefficients with the logarithm of the level of each record (of the pieces of one
    that was cut, together), a factor on its dynamic force; ``absorbed`` (R, R) how much of the level of a record (column) the
    fit takes up in the level that it has at another (row): the rest shows in that one's residual. ``influence`` (R, m)
    is what each record has moved the coefficients by: the sum of its products is the covariance where records are the clusters.
    """

    covariance: Array
    naive: Array
    counts: Array
    freedom: Array
    unidentifiable: tuple[int, ...]
    few: tuple[int, ...]
    records: Array
    within: Bools
    by_level: Array
    absorbed: Array
    influence: Array


def uncertainty(optimum: Optimum, held: tuple[int, ...] = ()) -> Uncertainty:
    """The covariance of the coefficients at the optimum; those ``held`` at a limit count as known."""
    problem = optimum.problem
    of_records = zip(optimum.cluster_sums, optimum.curvature_sums, strict=True)
    reduced = [_eliminate_nuisances(problem, sums, curvature, held) for sums, curvature in of_records]
    information = _sum_information(reduced, problem.size)
    samples = sum(piece.count - problem.locals for piece in problem.pieces)
    bread, unidentifiable = _invert(information, held)
    squares = sum(record.squares for record in reduced) / max(samples - problem.size, 1)
    naive = bread * (_estimate_variance(optimum, samples) if optimum.is_robust else squares)
    reduced = _join_pieces(problem, reduced)
    whole = [Reduced(r.scores.sum(axis=0)[None], r.information.sum(axis=0)[None], r.squares, r.raw) for r in reduced]
    records, cycles = _count_clusters(whole, information), _count_clusters(reduced, information)
    within = records.counts < MIN_RECORDS
    counts = np.where(within, cycles.counts, records.counts)
    linear = np.where(problem.is_linear, optimum.point.theta, 0.0)
    A = np.stack([record.information.sum(axis=0) for record in whole])
    between = 0.5 * (records.freedom + freedom_by_gains(A, bread, linear, records.freedom))
    freedom = np.where(within, cycles.freedom, between)
    inflation = np.where(within, cycles.freedom, records.freedom)
    # One stack of influences, so that the matrix is positive semidefinite whatever each coefficient is clustered by: over the
    # cycles of a record its influence as a whole is spread evenly, which keeps the sum of its squares.
    sizes = [record.scores.shape[0] for record in reduced]
    # the degrees of freedom are G - 1, so this is the root of the sandwich's G/(G - 1)
    by_record, wide = records.scores @ bread, np.sqrt((inflation + 1.0) / inflation)
    even = np.repeat(by_record / np.sqrt(sizes)[:, None], sizes, axis=0)
    influence = np.where(within, cycles.scores @ bread, even) * wide
    covariance = influence.T @ influence
    few = tuple(k for k in map(int, np.flatnonzero(counts < MIN_CYCLES)) if k not in (*held, *unidentifiable))
    unknown = (*unidentifiable, *few)
    return Uncertainty(
        _mark_infinite(covariance, unknown),
        _mark_infinite(naive, unknown),
        counts,
        freedom,
        unidentifiable,
        few,
        records.counts,
        within,
        *_respond_to_levels(optimum, whole, bread),
        by_record * wide,
    )


def record_groups(problem: Problem) -> dict[str, list[int]]:
    """The pieces of each record, by its name: those of one that was cut belong together."""
    groups: dict[str, list[int]] = {}
    for k, piece in enumerate(problem.pieces):
        groups.setdefault(piece.cut_from or piece.name, []).append(k)
    return groups


def _respond_to_levels(optimum: Optimum, parts: list[Reduced], bread: Array) -> tuple[Array, Array]:
    """``by_level`` and ``absorbed`` of `Uncertainty`."""
    problem = optimum.problem
    static = problem.composition.static
    powers = [
        0 if k in static else force_power(column.quantity.unit)
        for k, column in enumerate(problem.columns)
        for _ in range(column.size)
    ]
    b = np.array(powers, dtype=float) * optimum.point.theta
    if (
        "gain" in problem.common
    ):  # the records' own gains have taken their part: the mean level at an input is the fit's
        return _respond_to_mean_levels(problem, b)
    by_record = np.stack([record.information.sum(axis=0) @ b for record in parts])
    by_level = by_record @ bread
    # what a record's level looks like in its own residual: the projection of the coefficients' change on its force
    weight = np.maximum(by_record @ b, TINY)
    return by_level, by_record @ by_level.T / weight[:, None]


def _respond_to_mean_levels(problem: Problem, b: Array) -> tuple[Array, Array]:
    """As `_respond_to_levels` where every record has a gain of its own, so that the fit is at the mean level of each input's
    records."""
    groups = list(record_groups(problem).values())
    levels = np.array([round(float(np.mean([np.mean(problem.pieces[k].u) for k in pieces])), 6) for pieces in groups])
    if problem.varying:
        return np.tile(b / len(groups), (len(groups), 1)), np.full((len(groups),) * 2, 1.0 / len(groups))
    first = [pieces[0] for pieces in groups]
    by_level = np.zeros((len(groups), problem.size))
    for k, owned in enumerate(problem.slices):
        basis = problem.matrix[first, k, owned]
        if basis.size:
            by_level[:, owned] = (np.linalg.pinv(basis) @ np.diag(basis @ b[owned])).T
    same = levels[:, None] == levels[None, :]
    return by_level, same / same.sum(axis=1, keepdims=True)


@dataclass(frozen=True)
class Reduced:
    """One record's clusters once its nuisances have taken their part: J'r (g, G) and J'J (g, G, G); ``squares`` is its r'r,
    ``raw`` (G,) the diagonal of J'J before."""

    scores: Array
    information: Array
    squares: float
    raw: Array


def _join_pieces(problem: Problem, reduced: list[Reduced]) -> list[Reduced]:
    """The pieces of a record that was cut as one: they share its gain and its temperature, as its cycles do."""
    groups = [[reduced[k] for k in pieces] for pieces in record_groups(problem).values()]
    return [
        Reduced(
            np.concatenate([piece.scores for piece in pieces]),
            np.concatenate([piece.information for piece in pieces]),
            sum(piece.squares for piece in pieces),
            sum((piece.raw for piece in pieces), np.zeros(problem.size)),
        )
        for pieces in groups
    ]


def _estimate_variance(optimum: Optimum, samples: int) -> float:
    """Of a loss that is not squares: the mean square of its first derivative over the mean of its second."""
    problem, first, second = optimum.problem, 0.0, 0.0
    for piece, residual in zip(problem.pieces, optimum.residuals, strict=True):
        assert piece.second_weight is not None
        slope = (piece.weight * piece.spread) ** 2 * residual / piece.spread
        first += float(slope[piece.comparable] @ slope[piece.comparable])
        second += float(np.sum((piece.second_weight[piece.comparable] * piece.spread) ** 2))
    total = sum(piece.count for piece in problem.pieces)
    return first / max(second, TINY) * total / max(samples - problem.size, 1)


def _eliminate_nuisances(problem: Problem, sums: Array, second: Array, held: tuple[int, ...]) -> Reduced:
    L = problem.locals
    whole = second.sum(axis=0)
    taken = np.vstack((-_solve_nuisances(whole[:L, :L], whole[:L, L:-1]), np.eye(problem.size)))
    taken[:, list(held)] = 0.0
    raw = np.diag(whole)[L:-1]
    squares = float(np.sum(sums[:, -1, -1]))
    return Reduced(sums[:, :-1, -1] @ taken, taken.T @ second[:, :-1, :-1] @ taken, squares, raw)


def _sum_information(reduced: list[Reduced], size: int) -> Array:
    """The information of all records; none where the nuisances took all of a derivative but its rounding."""
    information = sum((record.information.sum(axis=0) for record in reduced), np.zeros((size, size)))
    lost = np.diag(information) <= SAME * sum((record.raw for record in reduced), np.zeros(size))
    information[lost, :] = information[:, lost] = 0.0
    return np.asarray(information)


def _solve_nuisances(of_nuisances: Array, across: Array) -> Array:
    """The nuisances' change with each coefficient: least squares on what the record determines of them."""
    # Newtons beside factors: scaled to ones on the diagonal, or the largest unit would decide what is rounding
    d = np.sqrt(np.diag(of_nuisances))
    scale = np.where(d > 0, 1.0 / np.where(d > 0, d, 1.0), 0.0)
    values, vectors = np.linalg.eigh(of_nuisances * np.outer(scale, scale))
    seen = values > SAME * max(float(values.max(initial=0.0)), 1e-300)
    weights = np.where(seen, 1.0 / np.where(seen, values, 1.0), 0.0)
    return np.asarray(scale[:, None] * (vectors @ (weights[:, None] * (vectors.T @ (scale[:, None] * across)))))


def _invert(information: Array, held: tuple[int, ...]) -> tuple[Array, tuple[int, ...]]:
    """The inverse on what is determined, and the coefficients that take part in a direction that is not."""
    scale = np.sqrt(np.diag(information))
    free = scale > 1e-12 * max(float(scale.max(initial=0.0)), 1e-300)
    unit = np.where(free, 1.0 / np.where(free, scale, 1.0), 0.0)
    values, vectors = np.linalg.eigh(information * np.outer(unit, unit))
    determined = values > UNDETERMINED**1.5 * max(float(values.max(initial=0.0)), 1e-300)
    inverse = (vectors[:, determined] / values[determined]) @ vectors[:, determined].T * np.outer(unit, unit)
    # a direction is lost to every coefficient that takes a visible part in it, not to its largest one alone
    lost = np.abs(vectors[:, ~determined & (values > -np.inf)]) > 1e-3
    unidentifiable = {int(k) for k in np.flatnonzero(~free | (lost.any(axis=1) & free)) if k not in held}
    return inverse, tuple(sorted(unidentifiable))


@dataclass(frozen=True)
class Clusters:
    """The scores (g, G) of all clusters, how many clusters determine each coefficient, and its degrees of freedom.

    These are one less than the effective number of clusters, 1 / sum of the squared shares of the information: G equal
    clusters count as G, and one that holds all counts as one.
    """

    scores: Array
    counts: Array
    freedom: Array


def _count_clusters(parts: list[Reduced], information: Array) -> Clusters:
    scores = np.concatenate([part.scores for part in parts])
    diagonals = np.concatenate([np.diagonal(part.information, axis1=1, axis2=2) for part in parts])
    total = np.diag(information)
    shares = np.where(total > TINY, diagonals / np.where(total > TINY, total, 1.0), 0.0)
    effective = 1.0 / np.maximum(np.sum(shares**2, axis=0), TINY)
    return Clusters(scores, np.sum(shares > 1e-3, axis=0), np.maximum(np.minimum(effective, len(scores)), 1.5) - 1.0)


def freedom_by_gains(A: Array, bread: Array, linear: Array, instead: Array) -> Array:
    r"""The degrees of freedom (G,) where records differ by a gain; ``instead`` (G,) where no coefficient is a gain's.

    With the gains :math:`\gamma_h` of the records the scores are :math:`s_g = A_g b \gamma_g - A_g B \sum_h A_h b \gamma_h`, A
    (n, G, G) the information of each record, B the ``bread``, b the ``linear`` coefficients (G,), which a gain multiplies. The
    variance of a coefficient is then a quadratic form Q of the gains, of which Satterthwaite's degrees of freedom are
    tr(Q)^2 / tr(Q^2).
    """
    by_gain = A @ linear
    influence = -np.einsum("gij,hj->ghi", A @ bread, by_gain)  # the fit follows the gains of all records
    places = np.arange(len(A))
    influence[places, places] += by_gain
    influence = influence @ bread  # (g, h, G): of the gain of record h on the influence of record g
    Q = np.einsum("ghk,gik->khi", influence, influence)
    trace, square = np.trace(Q, axis1=1, axis2=2), np.einsum("khi,kih->k", Q, Q)
    seen = square > TINY
    return np.where(seen, np.maximum(trace**2 / np.where(seen, square, 1.0), 0.5), instead)


def _mark_infinite(covariance: Array, unidentifiable: tuple[int, ...]) -> Array:
    out = covariance.copy()
    for k in unidentifiable:
        out[k, :] = out[:, k] = 0.0
        out[k, k] = np.inf
    return out
