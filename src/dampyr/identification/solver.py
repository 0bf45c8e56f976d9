r"""Separable least squares: the linear parameters solved inside, Levenberg-Marquardt on the few that are not.

The problem is :math:`\min \sum_r \|W_r (F_r - \hat F_r(\theta, \nu_r))\|^2` over the coefficients :math:`\theta` of all laws
and the nuisances :math:`\nu_r` of each record. Each record is compressed by a QR factorisation to a triangle of a dozen rows,
so the joint problem never holds more than that. The force is affine in the linear parameters, so one
solve brings them to their optimum; the step of the others is Kaufman's (1975) variant of the variable projection of Golub and
Pereyra (1973).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.design import Column
from dampyr.identification.pieces import Piece, Start, linearise
from dampyr.models import Composition

Array = NDArray[np.float64]
MOST_ITERATIONS = 80
TOLERANCE = 1e-8
SMALL_STEP = 1e-4  # of the sum of squares that a step of the linear unknowns alone has gained
ROUNDING = 1e-18  # of each sample's variance: records without noise are met to a billionth


@dataclass(frozen=True)
class Problem:
    """What is fitted to what."""

    composition: Composition
    columns: list[Column]
    pieces: list[Piece]
    offset: bool

    @property
    def slices(self) -> list[slice]:
        """Where each parameter's values stand among all coefficients."""
        ends = np.cumsum([0, *(c.size for c in self.columns)])
        return [slice(int(a), int(b)) for a, b in itertools.pairwise(ends)]

    @property
    def size(self) -> int:
        """How many coefficients there are."""
        return sum(c.size for c in self.columns)

    def is_linear(self) -> NDArray[np.bool_]:
        """Which coefficients the force is affine in."""
        return np.concatenate([np.full(c.size, c.quantity.linear) for c in self.columns]).astype(bool)

    def is_logarithmic(self) -> NDArray[np.bool_]:
        """Which coefficients are walked in their logarithm."""
        return np.concatenate([np.full(c.size, c.logarithmic) for c in self.columns]).astype(bool)

    def limits(self) -> tuple[Array, Array]:
        """The lowest and highest value of each coefficient."""
        low = np.concatenate([np.full(c.size, c.quantity.low) for c in self.columns])
        high = np.concatenate([np.full(c.size, c.quantity.high) for c in self.columns])
        return low, high


@dataclass(frozen=True)
class Point:
    """Where the search stands: all coefficients, and each record's nuisances."""

    theta: Array
    starts: tuple[Start, ...]

    def of(self, problem: Problem) -> list[Array]:
        """The coefficients by parameter."""
        return [self.theta[s] for s in problem.slices]


@dataclass(frozen=True)
class Triangle:
    """One record compressed: columns [nuisances, coefficients, residual], a triangle with the same normal equations."""

    rows: Array
    nuisances: int


@dataclass(frozen=True)
class Outcome:
    """Where the search ended, and why."""

    point: Point
    cost: float
    converged: bool
    reason: str
    iterations: int
    at_limit: tuple[int, ...]


def expand(problem: Problem, by_parameter: Array, u: Array | float) -> Array:
    """Derivatives by parameter (n, P) as derivatives by coefficient (n, size)."""
    blocks = [by_parameter[:, k : k + 1] * column.basis(u) for k, column in enumerate(problem.columns) if column.size]
    return np.concatenate(blocks, axis=1) if blocks else np.zeros((by_parameter.shape[0], 0))


def triangles(problem: Problem, point: Point) -> list[Triangle]:
    """Every record compressed around ``point``."""
    found = []
    theta = point.of(problem)
    for one, start in zip(problem.pieces, point.starts, strict=True):
        local = linearise(problem.composition, problem.columns, theta, one, start, problem.offset)
        L = local.by_nuisance.shape[1]
        if np.ndim(one.u):
            full = np.column_stack((local.by_nuisance, expand(problem, local.by_parameter, one.u), local.residual))
            rows = _triangle(full)
        else:
            small = _triangle(np.column_stack((local.by_nuisance, local.by_parameter, local.residual)))
            rows = np.column_stack((small[:, :L], expand(problem, small[:, L:-1], one.u), small[:, -1]))
        found.append(Triangle(rows, L))
    return found


def _triangle(columns: Array) -> Array:
    return np.asarray(np.linalg.qr(columns, mode="r"))


@dataclass(frozen=True)
class System:
    """All records' triangles as one least-squares system over [coefficients, nuisances of record 1, 2, ...]."""

    matrix: Array
    target: Array
    linear: NDArray[np.bool_]
    low: Array
    high: Array

    def solve(self, chosen: NDArray[np.bool_], damping: float = 0.0) -> Array:
        """The step of the chosen unknowns, the others held; bounds respected."""
        A, scale = self._scaled(chosen)
        b = self.target
        if damping:
            A = np.vstack((A, np.sqrt(damping) * np.eye(A.shape[1])))
            b = np.concatenate((b, np.zeros(A.shape[1])))
        step = np.linalg.lstsq(A, b, rcond=1e-12)[0] * scale
        low, high = self.low[chosen], self.high[chosen]
        if np.any(step < low) or np.any(step > high):
            with np.errstate(divide="ignore", invalid="ignore"):  # scale 0: the records do not see it
                low, high = low / scale, high / scale
            step = _bounded(A, b, low, high) * scale
        out = np.zeros(self.matrix.shape[1])
        out[chosen] = step
        return out

    def _scaled(self, chosen: NDArray[np.bool_]) -> tuple[Array, Array]:
        A = self.matrix[:, chosen]
        norms = np.linalg.norm(A, axis=0)
        scale = np.where(norms > 0, 1.0 / np.where(norms > 0, norms, 1.0), 0.0)
        return A * scale, scale

    def cost(self, step: Array) -> float:
        """Half the sum of squares after a step, as the linear model has it."""
        return 0.5 * float(np.sum((self.target - self.matrix @ step) ** 2))


def _bounded(A: Array, b: Array, low: Array, high: Array) -> Array:
    from scipy.optimize import lsq_linear

    low = np.where(np.isnan(low), -np.inf, np.minimum(low, 0.0))
    high = np.where(np.isnan(high), np.inf, np.maximum(high, 0.0))
    open_ = high - low > 1e-12
    out = np.zeros(A.shape[1])
    out[open_] = lsq_linear(A[:, open_], b, (low[open_], high[open_]), method="bvls", tol=1e-12).x
    return out


def system(problem: Problem, point: Point) -> System:
    """The linearised joint problem around ``point``."""
    found = triangles(problem, point)
    G, L = problem.size, sum(t.nuisances for t in found)
    rows = sum(t.rows.shape[0] for t in found)
    matrix, target = np.zeros((rows, G + L)), np.zeros(rows)
    top, left = 0, G
    for one in found:
        span = slice(top, top + one.rows.shape[0])
        matrix[span, :G] = one.rows[:, one.nuisances : -1]
        matrix[span, left : left + one.nuisances] = one.rows[:, : one.nuisances]
        target[span] = one.rows[:, -1]
        top, left = span.stop, left + one.nuisances
    linear, low, high = _kinds(problem, point)
    log = np.concatenate((problem.is_logarithmic(), np.zeros(L, dtype=bool)))
    scale = np.where(log, np.concatenate((point.theta, np.ones(L))), 1.0)
    return System(matrix * scale, target, linear, low, high)


def _kinds(problem: Problem, point: Point) -> tuple[NDArray[np.bool_], Array, Array]:
    """Which unknowns are linear, and how far each may step (logarithmic ones by a factor of e)."""
    low, high = problem.limits()
    log = problem.is_logarithmic()
    linear, lows, highs = [problem.is_linear()], [low - point.theta], [high - point.theta]
    lows[0] = np.where(log, -1.0, lows[0])
    highs[0] = np.where(log, np.minimum(1.0, np.log(np.maximum(high / np.where(log, point.theta, 1.0), 1.0))), highs[0])
    bounds = np.array(list(problem.composition.states.values())).reshape(-1, 2)
    for start in point.starts:
        if problem.offset:
            linear.append(np.array([True]))
            lows.append(np.array([-np.inf]))
            highs.append(np.array([np.inf]))
        linear.append(np.zeros(len(bounds), dtype=bool))
        lows.append(bounds[:, 0] - start.states)
        highs.append(bounds[:, 1] - start.states)
    return np.concatenate(linear), np.concatenate(lows), np.concatenate(highs)


def moved(problem: Problem, point: Point, step: Array) -> Point:
    """``point`` after a step (a factor exp(step) for what is walked in the logarithm), inside the limits to rounding."""
    G = problem.size
    log = problem.is_logarithmic()
    theta = np.where(log, point.theta * np.exp(np.where(log, step[:G], 0.0)), point.theta + step[:G])
    theta = _inside(problem, theta)
    bounds = np.array(list(problem.composition.states.values())).reshape(-1, 2)
    starts, at = [], G
    for start in point.starts:
        shift = float(step[at]) if problem.offset else 0.0
        at += int(problem.offset)
        states = np.clip(start.states + step[at : at + len(bounds)], bounds[:, 0], bounds[:, 1])
        at += len(bounds)
        starts.append(Start(start.offset + shift, states))
    return Point(theta, tuple(starts))


def _inside(problem: Problem, theta: Array) -> Array:
    """Rounding may leave a value a hair outside its limit; an open limit is left by a billionth of the force's scale."""
    low, high = problem.limits()
    open_low = np.concatenate([np.full(c.size, c.quantity.open_low) for c in problem.columns])
    floor = np.where(open_low & np.isfinite(low), low + 1e-9, low)
    return np.clip(theta, floor, high)


def search(problem: Problem, point: Point, progress: Callable[[int, float], None] | None = None) -> Outcome:
    """Minimise from ``point``; the reason says how it ended."""
    point, here, cost = _settled(problem, point)
    damping, reason, converged = 1e-3, "", False
    rounding = ROUNDING * sum(one.t.size for one in problem.pieces)
    iteration = 0
    for iteration in range(1, MOST_ITERATIONS + 1):
        everything = np.ones(here.matrix.shape[1], dtype=bool)
        step = here.solve(everything, damping)
        promised = cost - here.cost(here.solve(everything))
        if np.all(here.linear) or promised <= TOLERANCE * cost + rounding:
            converged, reason = True, "converged: no step lowers the sum of squares by more than 1e-8 of it"
            break
        new_point, new_here, new_cost = _settled(problem, moved(problem, point, step))
        if progress:
            progress(iteration, min(cost, new_cost))
        if new_cost < cost:
            point, here, cost = new_point, new_here, new_cost
            damping = max(damping / 10.0, 1e-12)
        else:
            damping *= 10.0
            if damping > 1e8:
                converged = promised <= 1e-6 * cost
                left = f"the last promised {promised / cost:.1g} of it"
                reason = f"stopped where no step lowers the sum of squares any more ({left})"
                break
    else:
        reason = f"did not converge: {MOST_ITERATIONS} steps were not enough"
    return Outcome(point, cost, converged, reason, iteration, _at_limit(problem, point))


def _settled(problem: Problem, point: Point) -> tuple[Point, System, float]:
    """``point`` with its linear unknowns at their optimum, and the system around it.

    The residual there is exact, the force being affine in these unknowns. Where their step was small, so are the changes of
    the other columns, and what was evaluated before it is kept.
    """
    here = system(problem, point)
    step = here.solve(here.linear)
    before, point = here.cost(np.zeros_like(step)), moved(problem, point, step)
    there = replace(here, target=here.target - here.matrix @ step, low=here.low - step, high=here.high - step)
    cost = there.cost(np.zeros_like(step))
    if before - cost > SMALL_STEP * cost:
        there = system(problem, point)
        cost = there.cost(np.zeros_like(step))
    return point, there, cost


def _at_limit(problem: Problem, point: Point) -> tuple[int, ...]:
    low, high = problem.limits()
    near = (point.theta <= low + 2e-9) | (point.theta >= high)
    return tuple(int(k) for k in np.flatnonzero(near & ~np.isnan(low)))


def projected_cost(problem: Problem, point: Point) -> float:
    """The cost at ``point`` with the linear unknowns at their optimum, without moving there."""
    here = system(problem, point)
    return here.cost(here.solve(here.linear))
