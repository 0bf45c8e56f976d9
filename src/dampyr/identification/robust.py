r"""Losses that are robust to outliers: iteratively reweighted least squares.

With the residual z of a sample over the scale of its record, 1.4826 times the median absolute residual, each round weighs
the samples and minimises the weighted sum of squares:

.. math:: w_\text{huber} = \min(1, 1.345/|z|), \qquad w_{l1} = 1/\sqrt{1 + (z/\varepsilon)^2}, \quad \varepsilon = 0.1

At its end the first minimises Huber's (1964) loss, the second :math:`\sum\sqrt{\varepsilon^2 + z^2}`, which is the L1
norm that dampyr scores by but for residuals below a tenth of the scale. The scales follow the residuals for a few rounds and
are held then, so that one sum goes down in every round that follows. The errors are the clustered sandwich of an M-estimator
(Huber 1967): the scores with these weights, the information with the second derivative of the loss.

Holland and Welsch (1977).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.normal_equations import modelled_force
from dampyr.identification.problem import Point, Problem
from dampyr.identification.variable_projection import Outcome, search

Array = NDArray[np.float64]
LOSSES = ("squares", "huber", "l1")
NORMAL = 1.4826  # a normal distribution's standard deviation over its median absolute value
KINK = 1.345  # Huber's constant: 95 % efficiency where residuals are normal
SMOOTHED = 0.1  # of the scale: below it the L1 loss is a parabola, so that it has a second derivative
SCALING_ROUNDS = 4  # in which the scales follow the residuals; held then, so that one sum goes down
MAX_ROUNDS = 100  # of weights, before the fit counts as not converged
ENOUGH = 1e-8  # of the loss: the change in a round


def check_loss(loss: str) -> None:
    """:class:`~dampyr.errors.InputError` unless there is such a loss."""
    if loss not in LOSSES:
        raise InputError(f"{loss!r} is an unknown loss; choose {', '.join(LOSSES)}")


def iteratively_reweighted(
    problem: Problem, outcome: Outcome, loss: str, progress: Callable[[int, float], None] | None = None
) -> tuple[Problem, Outcome]:
    """From the least-squares fit to that of ``loss``: the problem with its weights, and how the last search ended."""
    scales, before, steps = np.ones(len(problem.pieces)), np.inf, outcome.iterations
    for turn in range(MAX_ROUNDS):
        residuals = _residuals(problem, outcome.point)
        if turn < SCALING_ROUNDS:
            scales = np.array([max(NORMAL * float(np.median(np.abs(r))), 1e-12) for r in residuals])
        total = sum(float(np.sum(s**2 * _loss(r / s, loss))) for r, s in zip(residuals, scales, strict=True))
        if turn > SCALING_ROUNDS and abs(before - total) <= ENOUGH * total:
            reason = f"{outcome.reason}; {turn} rounds of weights" if outcome.converged else outcome.reason
            return _with_second_weights(problem, residuals, scales, loss), replace(
                outcome, iterations=steps, reason=reason
            )
        before = total
        weights = [np.sqrt(_weight(r / s, loss)) for r, s in zip(residuals, scales, strict=True)]
        pieces = [replace(p, weight=w / p.spread) for p, w in zip(problem.pieces, weights, strict=True)]
        problem = replace(problem, pieces=pieces)
        outcome = search(problem, outcome.point, progress, tolerance=1e-9)
        steps += outcome.iterations
    reason = f"did not converge: after {MAX_ROUNDS} rounds of weights the {loss} loss still changes"
    residuals = _residuals(problem, outcome.point)
    return _with_second_weights(problem, residuals, scales, loss), replace(
        outcome, converged=False, reason=reason, iterations=steps
    )


def _with_second_weights(problem: Problem, residuals: list[Array], scales: Array, loss: str) -> Problem:
    """The problem with the second derivative of the loss at each sample."""
    zs = [r / s for r, s in zip(residuals, scales, strict=True)]
    second_weights = [np.sqrt(_second(z, loss)) / p.spread for z, p in zip(zs, problem.pieces, strict=True)]
    return replace(
        problem, pieces=[replace(p, second_weight=w) for p, w in zip(problem.pieces, second_weights, strict=True)]
    )


def _residuals(problem: Problem, point: Point) -> list[Array]:
    """Measured less modelled force, over each record's spread."""
    return [(one.force - modelled_force(problem, point, r)) / one.spread for r, one in enumerate(problem.pieces)]


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
