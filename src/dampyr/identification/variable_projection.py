r"""Separable least squares: the linear parameters solved inside, Levenberg-Marquardt on the few that are not.

The problem is :math:`\min \sum_r \|W_r (F_r - \hat F_r(\theta, \nu_r))\|^2` over the coefficients :math:`\theta` of all laws
and the nuisances :math:`\nu_r` of each record. The force is affine in the linear parameters, so one solve brings them to
their optimum; the step of the others is Kaufman's (1975) variant of the variable projection of Golub and Pereyra (1973).
No model fits a damper to the noise, and with large residuals Gauss-Newton steps overshoot along what the records hardly
hold; so what the steps themselves tell about the second derivatives is added, as in NL2SOL (Dennis, Gay and Welsch 1981).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.fit_data import opening
from dampyr.identification.normal_equations import Normal, moved, normal
from dampyr.identification.problem import Point, Problem, Share, apart

Array = NDArray[np.float64]
MAX_ITERATIONS = 80
TOLERANCE = 1e-8
SMALL_STEP = 0.1  # of the sum of squares that a step of the linear unknowns alone has gained
STALLED = 1e-5  # of the cost: less than a tenth of what one effective sample in 10,000 is worth
SURPRISE = 0.1  # of what a step promised: beyond it the second derivatives are learnt
NEAR = 0.1  # of the cost: steps that promise more are too far from the end to learn from
COARSE = 1e-4  # of the cost: where searches on some of the samples end
OPENING_SAMPLES = 1500  # of each record, with which a search begins
LEAST_SAVED = 3.0  # times the samples, for that to be worth it
DAMPING = 1e-3  # of a search that begins, as a part of each diagonal element
NEARBY = 1e-6  # of one that begins near its end
ROUNDING = 1e-18  # of each sample's variance: records without noise are met to a billionth
CONVERGED = "converged: no step lowers the sum of squares by more than 1e-8 of it"


@dataclass(frozen=True)
class Outcome:
    """Where the search ended, and why."""

    point: Point
    cost: float
    converged: bool
    reason: str
    iterations: int
    at_limit: tuple[int, ...]


def search(
    problem: Problem,
    point: Point,
    progress: Callable[[int, float], None] | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
) -> Outcome:
    """Minimise from ``point``; the reason says how it ended. Parts that share no coefficient are searched apart."""
    theta, local = point.theta.copy(), point.local.copy()
    ended = []
    for share in apart(problem):
        outcome = _search_in_stages(
            share.problem, Point(theta[share.coefficients], local[share.records]), progress, tolerance, max_iterations
        )
        theta[share.coefficients], local[share.records] = outcome.point.theta, outcome.point.local
        ended.append((share, outcome))
    end = Point(theta, local)
    converged, reason = _reasons(ended)
    return Outcome(
        end,
        sum(outcome.cost for _, outcome in ended),
        converged,
        reason,
        max(outcome.iterations for _, outcome in ended),
        _at_limit(problem, end),
    )


def _search_in_stages(
    problem: Problem, point: Point, progress: Callable[[int, float], None] | None, tolerance: float, max_iterations: int
) -> Outcome:
    """The search on the first part of each record, then on all samples: only there can it converge."""
    short = _opening(problem)
    if short is None or max_iterations < 2:
        return descend(problem, point, progress, tolerance, max_iterations)
    near = descend(short, point, None, max(COARSE, tolerance), max_iterations // 2)
    if not np.isfinite(near.cost):
        return descend(problem, point, progress, tolerance, max_iterations)
    _share_cache(short, problem)
    done = near.iterations

    def report_progress(iteration: int, cost: float) -> None:
        if progress:
            progress(done + iteration, cost)

    outcome = descend(problem, near.point, report_progress, tolerance, max_iterations - done, NEARBY)
    return replace(outcome, iterations=done + outcome.iterations)


def _opening(problem: Problem) -> Problem | None:
    """The problem on the first part of each record; None where that saves little, or an input varies.

    A fit that is weighted sample by sample begins at the end of another, which a part of the samples would only leave.
    """
    if problem.varying or any(one.weight.size > 1 for one in problem.pieces):
        return None
    pieces = [opening(one, OPENING_SAMPLES) for one in problem.pieces]
    if sum(one.t.size for one in problem.pieces) < LEAST_SAVED * sum(one.t.size for one in pieces):
        return None
    short = replace(problem, pieces=pieces)
    _share_cache(problem, short)
    return short


def _share_cache(one: Problem, other: Problem) -> None:
    """What one problem has worked out from its columns holds for the other, on the same records' samples."""
    other.__dict__.update((key, value) for key, value in one.__dict__.items() if key != "pieces")


def _reasons(ended: list[tuple[Share, Outcome]]) -> tuple[bool, str]:
    """How all parts ended: the first that did not converge speaks for all."""
    failed = [(share, outcome) for share, outcome in ended if not outcome.converged]
    share, outcome = (failed or ended)[0]
    where = f" (records at {np.mean(share.problem.pieces[0].u):g} {share.problem.pieces[0].unit})"
    return not failed, outcome.reason + (where if failed and len(ended) > 1 else "")


def descend(
    problem: Problem,
    point: Point,
    progress: Callable[[int, float], None] | None,
    tolerance: float,
    max_iterations: int = MAX_ITERATIONS,
    damping: float = DAMPING,
) -> Outcome:
    """Minimise one problem whose records share coefficients."""
    point, here = _settled(problem, point)
    if not here.finite:
        return Outcome(point, float("inf"), False, "did not begin: the model's force is not finite at the start", 0, ())
    reason, converged = "", False
    curvature: Array | None = None
    rounding = ROUNDING * sum(one.t.size for one in problem.pieces)
    all_linear = bool(np.all(here.linear) and np.all(here.local_linear))
    iteration = 0
    for iteration in range(1, max_iterations + 1):
        step = here.solve(damping=damping, curvature=curvature)
        promised = here.gain(step)
        if promised <= tolerance * here.cost + rounding:
            promised = here.gain(here.solve())
        if all_linear or promised <= tolerance * here.cost + rounding:
            converged, reason = True, CONVERGED
            break
        new_point, new_here = _settled(problem, moved(problem, point, step))
        if progress:
            progress(iteration, min(here.cost, new_here.cost) if new_here.finite else here.cost)
        if new_here.cost < here.cost:
            surprise = abs(here.cost - new_here.cost - promised)
            if SURPRISE * promised < surprise and promised < NEAR * here.cost:
                walked = new_point.coordinates(problem) - point.coordinates(problem)
                curvature = _learnt(curvature, here, new_here, walked)
            else:
                curvature = None
            point, here = new_point, new_here
            damping = max(damping / 10.0, 1e-12)
        else:
            damping *= 10.0
            curvature = None
            if damping > 1e8:
                converged = promised <= STALLED * here.cost
                left = f"the last promised {promised / here.cost:.1g} of it"
                reason = f"stopped where no step lowers the sum of squares any more ({left})"
                break
    else:
        reason = f"did not converge: {max_iterations} steps were not enough"
    return Outcome(point, here.cost, converged, reason, iteration, _at_limit(problem, point))


def _settled(problem: Problem, point: Point) -> tuple[Point, Normal]:
    """``point`` with its linear unknowns at their optimum, and the normal equations around it.

    The residual there is exact, the force being affine in these unknowns. Where their step was small, so are the changes of
    the other derivatives, and what was evaluated before it is kept.
    """
    here = normal(problem, point)
    if not here.finite:
        return point, here
    step = here.solve(only_linear=True)
    point = moved(problem, point, step)
    there = here.after(step)
    if here.cost - there.cost > SMALL_STEP * there.cost:
        there = normal(problem, point)
    return point, there


def _learnt(curvature: Array | None, old: Normal, new: Normal, step: Array) -> Array:
    """The second derivatives that the normal equations leave out, as the last step shows them.

    The update of Dennis, Gay and Welsch (1981) with their sizing, on the coefficients with the nuisances eliminated.
    """
    here, there = old.reduced, new.reduced
    curvature = np.zeros_like(here.matrix) if curvature is None else curvature
    change = here.target - there.target
    left = change - there.matrix @ step
    sized = curvature @ step
    if float(step @ sized) != 0.0:
        curvature = curvature * min(1.0, abs(float(step @ left) / float(step @ sized)))
    along = float(change @ step)
    if along <= 1e-12 * float(np.linalg.norm(change) * np.linalg.norm(step)):
        return np.zeros_like(curvature)
    rest = left - curvature @ step
    update = np.outer(rest, change) + np.outer(change, rest)
    return np.asarray(curvature + update / along - float(step @ rest) * np.outer(change, change) / along**2)


def _at_limit(problem: Problem, point: Point) -> tuple[int, ...]:
    low, high = problem.limits
    near = (point.theta <= low + 2e-9) | (point.theta >= high)
    return tuple(int(k) for k in np.flatnonzero(near & ~np.isnan(low)))


def projected_cost(problem: Problem, point: Point) -> float:
    """The cost at ``point`` with the linear unknowns at their optimum, without moving there."""
    here = normal(problem, point)
    return here.after(here.solve(only_linear=True)).cost if here.finite else float("inf")
