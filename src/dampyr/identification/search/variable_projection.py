r"""Separable least squares: the linear parameters solved inside, Levenberg-Marquardt on the few that are not.

The problem is :math:`\min \sum_r \|W_r (F_r - \hat F_r(\theta, \nu_r))\|^2` over the coefficients :math:`\theta` of all laws
and the nuisances :math:`\nu_r` of each record. The force is affine in the linear parameters, so one solve brings them to
their optimum; the step of the others is Kaufman's (1975) variant of the variable projection of Golub and Pereyra (1973).
No model fits a damper to the noise, and with large residuals Gauss-Newton steps overshoot along what the records hardly
determine; so a secant estimate of the second derivatives is added, as in NL2SOL (Dennis, Gay and Welsch 1981).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.search.fit_data import first_part
from dampyr.identification.search.normal_equations import NormalEquations, SearchStep, linearise, step_point
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem, SearchPoint, independent_blocks
from dampyr.identification.search.work import Work

Array = NDArray[np.float64]
MAX_ITERATIONS = 80  # unless a fit gives `steps`
TOLERANCE = 1e-8  # of the cost: one effective sample in 10,000 is worth 1e-4
SMALL_STEP = 0.1  # of the sum of squares that a step of the linear unknowns alone has gained
STALLED = 1e-5  # of the cost: less than a tenth of what one effective sample in 10,000 is worth
MISPREDICTION = 0.1  # of the predicted reduction: errors beyond it update the second derivatives
SECANT_RANGE = 0.1  # of the cost: steps that promise more are too far from the end for a secant update
COARSE_TOLERANCE = 1e-4  # of the cost: where searches on some of the samples end
FIRST_SAMPLES = 1500  # of each record, with which a search begins
MIN_SAVING = 3.0  # times fewer samples, for that to be worth it
FLAT_STEPS = 10  # that together lower the cost by `STALLED` of it: what they still change, the records hardly determine
MAX_DAMPING = 1e8  # a step of a hundred-millionth of its length
SAME_STEP = 0.05  # of a step's length, each coefficient in units of its own error, or of its promise
DAMPING = 1e-3  # of a search that begins, as a part of each diagonal element
WARM_DAMPING = 1e-6  # of one that begins near its end
ROUNDING = 1e-18  # of each sample's variance: records without noise are met to a billionth
CONVERGED = "converged: no step lowers the sum of squares by more than 1e-8 of it"
FLAT = "converged: along a flat valley, where a step lowers the sum of squares by less than 1e-5 of it"


@dataclass(frozen=True)
class Outcome:
    """How a search ended, and where; ``work`` is what a fit has spent on it, counted s: `dampyr.identification.search.work`."""

    optimum: Optimum
    cost: float
    converged: bool
    reason: str
    iterations: int
    at_limit: tuple[int, ...]
    work: float = 0.0

    @property
    def point(self) -> SearchPoint:
        """The point where it ended."""
        return self.optimum.point


def search(
    problem: Problem,
    point: SearchPoint,
    progress: Callable[[int, float], None] | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
    work: Work | None = None,
) -> Outcome:
    """Minimise from ``point``; the reason says how it ended. Blocks that share no coefficient are searched one by one.

    No step begins once ``work`` is used up, of which each block has an equal share.
    """
    work = Work() if work is None else work
    theta, local = point.theta.copy(), point.local.copy()
    outcomes = []
    blocks = independent_blocks(problem)
    for k, block in enumerate(blocks):
        start = SearchPoint(theta[block.coefficients], local[block.records])
        share = work.share(len(blocks) - k)
        outcome = _search_in_stages(block.problem, start, progress, tolerance, max_iterations, share)
        work.spent += share.spent
        theta[block.coefficients], local[block.records] = outcome.point.theta, outcome.point.local
        outcomes.append((block, outcome))
    end = SearchPoint(theta, local)
    failed = [(block, outcome) for block, outcome in outcomes if not outcome.converged]
    block, reported = (failed or outcomes)[0]
    where = f" (records at {np.mean(block.problem.pieces[0].u):g} {block.problem.pieces[0].unit})"
    return Outcome(
        optimum=Optimum(problem, end),
        cost=sum(outcome.cost for _, outcome in outcomes),
        converged=not failed,
        reason=reported.reason + (where if failed and len(outcomes) > 1 else ""),
        iterations=max(outcome.iterations for _, outcome in outcomes),
        at_limit=_list_at_limit(problem, end),
    )


def _search_in_stages(
    problem: Problem,
    point: SearchPoint,
    progress: Callable[[int, float], None] | None,
    tolerance: float,
    max_iterations: int,
    work: Work,
) -> Outcome:
    """The search on the first part of each record, then on all samples: only there can it converge."""
    short = decimated_problem(problem)
    if short is None or max_iterations < 2:
        return levenberg_marquardt(problem, point, progress, tolerance, max_iterations, work=work)
    near = levenberg_marquardt(short, point, None, max(COARSE_TOLERANCE, tolerance), max_iterations // 2, work=work)
    if not np.isfinite(near.cost):
        return levenberg_marquardt(problem, point, progress, tolerance, max_iterations, work=work)
    done = near.iterations

    def report_progress(iteration: int, cost: float) -> None:
        if progress:
            progress(done + iteration, cost)

    rest = max_iterations - done
    outcome = levenberg_marquardt(problem, near.point, report_progress, tolerance, rest, WARM_DAMPING, work)
    return replace(outcome, iterations=done + outcome.iterations)


def decimated_problem(problem: Problem) -> Problem | None:
    """The problem on the first part of each record; None where that saves little, or an input varies.

    A fit that is weighted sample by sample begins at the end of another, which a part of the samples would only leave.
    """
    if problem.varying or any(piece.weight.size > 1 for piece in problem.pieces):
        return None
    pieces = [first_part(piece, FIRST_SAMPLES) for piece in problem.pieces]
    if sum(piece.t.size for piece in problem.pieces) < MIN_SAVING * sum(piece.t.size for piece in pieces):
        return None
    return replace(problem, pieces=pieces)


def levenberg_marquardt(
    problem: Problem,
    point: SearchPoint,
    progress: Callable[[int, float], None] | None,
    tolerance: float,
    max_iterations: int = MAX_ITERATIONS,
    damping: float = DAMPING,
    work: Work | None = None,
) -> Outcome:
    """Minimise one problem whose records share coefficients."""
    work = Work() if work is None else work
    point, equations = solve_linear_parameters(problem, point, work)
    if not equations.finite:
        return Outcome(
            Optimum(problem, point),
            float("inf"),
            False,
            "did not begin: the model's force is not finite at the start",
            0,
            (),
        )
    reason, converged = "", False
    curvature: Array | None = None
    rounding = ROUNDING * sum(piece.t.size for piece in problem.pieces)
    all_linear = bool(np.all(equations.linear) and np.all(equations.local_linear))
    iteration, costs = 0, [np.inf] * FLAT_STEPS
    for iteration in range(1, max_iterations + 1):
        step = equations.solve(damping=damping, curvature=curvature)
        predicted = equations.reduction(step)
        small = predicted <= tolerance * equations.cost + rounding
        if small:  # perhaps only because the damping makes it short: what a whole step promises decides
            predicted = equations.reduction(equations.solve())
        if all_linear or predicted <= tolerance * equations.cost + rounding:
            converged, reason = True, CONVERGED
            break
        slow = costs[-FLAT_STEPS] - equations.cost <= STALLED * equations.cost
        refused = small and damping >= 1.0  # longer steps were, so what a whole one promises is not to be had
        if (slow or refused) and predicted <= STALLED * equations.cost:
            converged, reason = True, FLAT
            break
        costs.append(equations.cost)
        new_point, new_equations = solve_linear_parameters(problem, step_point(problem, point, step), work)
        if progress:
            progress(iteration, min(equations.cost, new_equations.cost) if new_equations.finite else equations.cost)
        if new_equations.cost < equations.cost:
            misprediction = abs(equations.cost - new_equations.cost - predicted)
            if MISPREDICTION * predicted < misprediction and predicted < SECANT_RANGE * equations.cost:
                change = new_point.coordinates(problem) - point.coordinates(problem)
                curvature = update_secant_hessian(curvature, equations, new_equations, change)
            else:  # the linear model predicts well, and far from the end a secant would describe another place
                curvature = None
            point, equations = new_point, new_equations
            damping = max(damping / 10.0, 1e-12)
        else:
            damping = more_damping(equations, step, damping)
            curvature = None
            if damping > MAX_DAMPING:
                converged = predicted <= STALLED * equations.cost
                left = f"the last promised {predicted / equations.cost:.1g} of it"
                reason = f"stopped where no step lowers the sum of squares any more ({left})"
                break
        if work.stopped:
            reason = work.stopped
            break
    else:
        reason = f"did not converge: {max_iterations} steps were not enough"
    return Outcome(
        Optimum(problem, point), equations.cost, converged, reason, iteration, _list_at_limit(problem, point)
    )


def more_damping(equations: NormalEquations, step: SearchStep, damping: float) -> float:
    """The damping after a step that was refused: tens more until the step is another one.

    Where the damping is far below the smallest eigenvalue of the scaled normal equations, ten times more changes nothing, and
    an evaluation would show the same refusal.
    """
    scale = np.sqrt(np.maximum(np.diag(equations.reduced.matrix), 0.0))
    length, promise = float(np.linalg.norm(scale * step.theta)), equations.reduction(step)
    while damping <= MAX_DAMPING:
        damping *= 10.0
        other = equations.solve(damping=damping)
        shorter = float(np.linalg.norm(scale * (other.theta - step.theta))) > SAME_STEP * length
        if shorter or abs(equations.reduction(other) - promise) > SAME_STEP * promise:
            break
    return damping


def solve_linear_parameters(problem: Problem, point: SearchPoint, work: Work) -> tuple[SearchPoint, NormalEquations]:
    """``point`` with its linear unknowns at their optimum, and the normal equations around it.

    The residual there is exact, the force being affine in these unknowns. Where their step was small, so are the changes of
    the other derivatives, and what was evaluated before it is kept.
    """
    work.count(problem)
    before = linearise(problem, point)
    if not before.finite:
        return point, before
    step = before.solve(only_linear=True)
    point = step_point(problem, point, step)
    after = before.after(step)
    if before.cost - after.cost > SMALL_STEP * after.cost:
        work.count(problem)
        after = linearise(problem, point)
    return point, after


def update_secant_hessian(curvature: Array | None, old: NormalEquations, new: NormalEquations, step: Array) -> Array:
    """The second derivatives that the normal equations leave out, by the secant of the last step.

    The update of Dennis, Gay and Welsch (1981) with their sizing, on the coefficients with the nuisances eliminated.
    """
    before, after = old.reduced, new.reduced
    curvature = np.zeros_like(before.matrix) if curvature is None else curvature
    # the secant condition: the second derivatives, along the step, are what the gradient's change leaves to explain
    change = before.target - after.target
    left = change - after.matrix @ step
    sized = curvature @ step
    if float(step @ sized) != 0.0:
        curvature = curvature * min(1.0, abs(float(step @ left) / float(step @ sized)))
    along = float(change @ step)
    if along <= 1e-12 * float(np.linalg.norm(change) * np.linalg.norm(step)):
        return np.zeros_like(curvature)
    rest = left - curvature @ step
    update = np.outer(rest, change) + np.outer(change, rest)
    return np.asarray(curvature + update / along - float(step @ rest) * np.outer(change, change) / along**2)


def _list_at_limit(problem: Problem, point: SearchPoint) -> tuple[int, ...]:
    low, high = problem.limits
    near = (point.theta <= low + 2e-9) | (point.theta >= high)
    return tuple(int(k) for k in np.flatnonzero(near & ~np.isnan(low)))


def projected_cost(problem: Problem, point: SearchPoint, work: Work) -> float:
    """The cost at ``point`` with the linear unknowns at their optimum, without moving there."""
    work.count(problem)
    equations = linearise(problem, point)
    return equations.after(equations.solve(only_linear=True)).cost if equations.finite else float("inf")
