r"""Losses that are robust to outliers: iteratively reweighted least squares.

With the residual e of a sample in N, the scale :math:`s_r` of its record, 1.4826 times the median absolute residual, and
:math:`z = e/s_r`, the sums over all records r and their samples are

.. math:: \sum_r \omega_r \Big(\frac{s_r}{\sigma_r}\Big)^2 \sum_i \rho_\text{huber}(z_i), \qquad
          \sum_r \omega_r \frac{s_r}{d_r} \sum_i \sqrt{\varepsilon^2 + z_i^2}, \quad \varepsilon = 0.1

:math:`\sigma_r` is the standard deviation of the record's force, :math:`d_r` its mean absolute deviation from the middle of
its range (see `dampyr.identification.score`), and :math:`\omega_r` the weight of the record (see
`dampyr.identification.fit`). The first is Huber's (1964) loss: the sum of squares of a fit by ``"squares"`` where no residual
exceeds 1.345 scales. The second is :math:`\sum_r \omega_r \sum_i |e_i|/d_r` but for residuals below a tenth of the scale:
where records weigh the same, the sum of the L1 ratios that dampyr scores by. The scales say only where a residual counts as
large or small; they do not weigh one record against another.

Each round weighs the samples and minimises the weighted sum of squares, with

.. math:: w_\text{huber} = \min(1, 1.345/|z|), \qquad w_{l1} = \frac{1}{s_r}\big/\sqrt{1 + (z/\varepsilon)^2}

The scales follow the residuals for a few rounds and are held then, so that one sum goes down in every round that follows. The
errors are the clustered sandwich of an M-estimator (Huber 1967): the scores with these weights, the information with the second
derivative of the loss.

Holland and Welsch (1977).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.scoring.score import span
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem
from dampyr.identification.search.variable_projection import Outcome, search
from dampyr.identification.search.work import Work

Array = NDArray[np.float64]
NORMAL = 1.4826  # a normal distribution's standard deviation over its median absolute value
KINK = 1.345  # Huber's constant: 95 % efficiency where residuals are normal
SMOOTHED = 0.1  # of the scale: below it the L1 loss is a parabola, so that it has a second derivative
SCALING_ROUNDS = 4  # in which the scales follow the residuals; held then, so that one sum goes down
MAX_ROUNDS = 100  # of weights, before the fit counts as not converged
ENOUGH = 1e-8  # of the loss: the change in a round


def iteratively_reweighted(
    outcome: Outcome,
    loss: str,
    progress: Callable[[int, float], None] | None = None,
    work: Work | None = None,
) -> Outcome:
    """From the least-squares fit to that of ``loss``: how the last search ended, its problem with the weights of the loss."""
    work = Work() if work is None else work
    unweighted = outcome.optimum.problem
    scales, before, steps = np.ones(len(unweighted.pieces)), np.inf, outcome.iterations
    for turn in range(MAX_ROUNDS):
        residuals = _scale_residuals(outcome.optimum)
        residuals_compared = [r[piece.comparable] for r, piece in zip(residuals, unweighted.pieces, strict=True)]
        if turn < SCALING_ROUNDS:
            scales = np.array([max(NORMAL * float(np.median(np.abs(r))), 1e-12) for r in residuals_compared])
        shares = _compute_shares(unweighted, scales, loss)
        sums = [float(np.sum(s**2 * _loss(r / s, loss))) for r, s in zip(residuals_compared, scales, strict=True)]
        total = float(shares @ sums)
        if turn > SCALING_ROUNDS and abs(before - total) <= ENOUGH * total:
            reason = f"{outcome.reason}; {turn} rounds of weights" if outcome.converged else outcome.reason
            end = Optimum(_weigh(unweighted, residuals, scales, loss), outcome.point)
            return replace(outcome, optimum=end, iterations=steps, reason=reason)
        before = total
        weighted = _weigh(unweighted, residuals, scales, loss, second=False)
        outcome = search(weighted, outcome.point, progress, tolerance=1e-9, work=work)
        steps += outcome.iterations
        if work.stopped:
            break
    changes = f"did not converge: after {MAX_ROUNDS} rounds of weights the {loss} loss still changes"
    reason = work.stopped or changes
    end = Optimum(_weigh(unweighted, _scale_residuals(outcome.optimum), scales, loss), outcome.point)
    return replace(outcome, optimum=end, converged=False, reason=reason, iterations=steps)


def _compute_shares(problem: Problem, scales: Array, loss: str) -> Array:
    """(M,) By which the squares of each record's weights are multiplied, 1 on average of what differs between records."""
    records = np.array([float((p.weight[0] * p.spread) ** 2) for p in problem.pieces])
    if loss == "huber":
        return records
    forces = [p.force[p.comparable] for p in problem.pieces]
    mean_deviations = [float(np.mean(np.abs(force - np.mean(span(force))))) for force in forces]
    deviations = np.array([p.spread for p in problem.pieces]) / np.array(mean_deviations)
    # the L1 sum weighs by s/d, the squares here by (s/sigma)^2: what differs between records is that ratio, 1 on average
    return np.asarray(records * deviations / np.mean(deviations) * np.mean(scales) / scales)


def _weigh(problem: Problem, residuals: list[Array], scales: Array, loss: str, second: bool = True) -> Problem:
    """The problem with the weight of each sample by the loss, and by its second derivative."""
    pieces = []
    for p, r, s, share in zip(problem.pieces, residuals, scales, _compute_shares(problem, scales, loss), strict=True):
        curved = np.sqrt(share * _second(r / s, loss)) / p.spread if second else None
        pieces.append(replace(p, weight=np.sqrt(share * _weight(r / s, loss)) / p.spread, second_weight=curved))
    return replace(problem, pieces=pieces)


def _scale_residuals(optimum: Optimum) -> list[Array]:
    """Measured less modelled force, over each record's spread."""
    return [residual / piece.spread for residual, piece in zip(optimum.residuals, optimum.problem.pieces, strict=True)]


def _weight(z: Array, loss: str) -> Array:
    if loss == "huber":
        return np.minimum(1.0, KINK / np.maximum(np.abs(z), KINK))
    return np.asarray(1.0 / np.sqrt(1.0 + (z / SMOOTHED) ** 2))


def _second(z: Array, loss: str) -> Array:
    if loss == "huber":
        return np.asarray(np.abs(z) <= KINK, dtype=float)
    return np.asarray((1.0 + (z / SMOOTHED) ** 2) ** -1.5)


def _loss(z: Array, loss: str) -> Array:
    """The loss whose gradient is weight times z."""
    if loss == "huber":
        size = np.abs(z)
        return np.where(size <= KINK, 0.5 * z**2, KINK * (size - 0.5 * KINK))
    return np.asarray(SMOOTHED**2 * (np.sqrt(1.0 + (z / SMOOTHED) ** 2) - 1.0))
