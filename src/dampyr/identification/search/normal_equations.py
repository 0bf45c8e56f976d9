"""The normal equations around a point: sums of products of derivatives and residuals, and steps inside the limits.

The sums are taken while the kernel integrates along a record, so the derivatives are never stored; what is lost against an
orthogonal factorisation are directions whose derivatives agree to one part in a million, which the records do not determine
anyway (see `dampyr.identification.parameter_uncertainty.uncertainty`). The unknowns of one record are coupled to those of
another only by the coefficients, so a record's nuisances are eliminated from its own sums (a Schur complement), and the joint
problem is never larger than the coefficients. What is done in each step of a search for every unknown is compiled by numba
(`KERNELS`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import exp, isfinite, log

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.search.bounded_least_squares import SINGULAR, solve_bounded
from dampyr.identification.search.fit_data import Piece
from dampyr.identification.search.parametrisation import bases
from dampyr.identification.search.problem import (
    MISFIT,
    PRIOR,
    Problem,
    SearchPoint,
    SummationPlan,
    has_lag,
    input_at,
    summation_plan,
    values_at,
)
from dampyr.models.codegen.kernels import compile_cached
from dampyr.models.path_integration import (
    along,
    along_with_columns,
    along_with_laws,
    delayed,
    delayed_by_tau,
    products_along,
)
from dampyr.records.conditioning.moving_average import averaged

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Integers = NDArray[np.int64]
LAG_STEP = 1e-6  # s, of the difference that gives the derivative by a lag
CURVATURE_RANGE = (0.2, 10.0)  # of H: a secant estimate beyond it is of another place, or of noise
MAX_TURNS = 12  # of letting nuisances go to their limits and back
RIDGE = 1e-13  # of each record's nuisances, so that two with the same derivatives share their step


def products(problem: Problem, point: SearchPoint, by_cluster: bool = False) -> list[Array]:
    """The sums of products of each record over [nuisances, coefficients, residual], (groups, K, K) with K = L + G + 1.

    One group, or one per cluster of the record's samples. The residual is measured less model.
    """
    return [_sum_record(problem, point, r, by_cluster) for r in range(len(problem.pieces))]


def _sum_record(problem: Problem, point: SearchPoint, r: int, by_cluster: bool) -> Array:
    piece, u = problem.pieces[r], input_at(problem, point, r)
    values, gain = values_at(problem, point, r, u), point.nuisance(problem, r, "gain")
    states, force = point.states(problem, r), piece.force - point.nuisance(problem, r, "offset")
    lags = has_lag(problem)
    plan = summation_plan(problem, bases(problem.columns, u, piece.temperature)) if lags else problem.plans[r]
    factor, matrix = _scale_plan(problem, point, r, plan, values, gain)
    ends = piece.ends if by_cluster else np.array([piece.t.size])
    remembers = values.ndim > 1 and bool(problem.composition.delay is not None or len(states) or lags)
    if remembers or piece.average is not None:
        by_lag = _differentiate_by_lag(problem, point, r) if lags else None
        sums = _sum_stored(problem, piece, values, states, force, plan.source, factor, gain, ends, by_lag)
    else:
        path = (piece.t, piece.x, piece.v, problem.accelerations[r])
        sums = products_along(
            problem.composition, path, values, states, force, piece.weight, plan.source, factor, gain, ends
        )
    with np.errstate(
        invalid="ignore"
    ):  # a step to where the force is no number, such as beyond a gas column: it is not taken
        return np.asarray(matrix.T @ sums @ matrix)


def _differentiate_by_lag(problem: Problem, point: SearchPoint, r: int) -> Array:
    """The derivative (n,) of the force of the parts by the lag, by a difference."""
    piece, sides = problem.pieces[r], []
    for more in (LAG_STEP, 0.0):
        values = values_at(problem, point, r, input_at(problem, point, r, more))
        sides.append(along(problem.composition, piece.t, piece.x, piece.v, values, point.states(problem, r)))
    return np.asarray((sides[0] - sides[1]) / LAG_STEP)


def _scale_plan(
    problem: Problem, point: SearchPoint, r: int, plan: SummationPlan, values: Array, gain: float
) -> tuple[Array, Array]:
    """The factors and the matrix of a plan with what changes from point to point: gain, temperature."""
    if not {"gain", "temperature"} & set(problem.common):
        return plan.factor, plan.to_unknowns
    is_offset = plan.source == len(problem.columns) + len(problem.path_start) + 1
    factor, matrix = plan.factor * np.where(is_offset, 1.0, gain), plan.to_unknowns
    if "temperature" in problem.common:
        warmth = point.nuisance(problem, r, "temperature")
        is_viscous = np.where(plan.parameter >= 0, problem.is_viscous[plan.parameter], False)
        factor = factor * np.where(is_viscous, warmth, 1.0)
        matrix = matrix.copy()
        by_temperature = np.where(is_viscous, _differentiate_by_temperature(problem, point, plan, values, warmth), 0.0)
        matrix[:-1, problem.common.index("temperature")] = by_temperature
    return np.ascontiguousarray(factor), matrix


def _differentiate_by_temperature(
    problem: Problem, point: SearchPoint, plan: SummationPlan, values: Array, warmth: float
) -> Array:
    """What multiplies each column so that their sum is the derivative by the logarithm of the viscosity's factor."""
    if not problem.varying:
        return np.where(plan.parameter >= 0, values[plan.parameter], 0.0) / warmth
    theta = plan.to_unknowns[:-1, problem.locals : -1] @ point.theta
    fixed = np.array([problem.columns[k].fixed or 0.0 if k >= 0 else 0.0 for k in plan.parameter])
    return np.asarray(theta + fixed)


def _sum_stored(
    problem: Problem,
    piece: Piece,
    values: Array,
    states: Array,
    force: Array,
    source: Integers,
    factor: Array,
    gain: float,
    ends: Integers,
    by_lag: Array | None,
) -> Array:
    """As the kernel does it, with the derivatives stored.

    For an input that varies while states remember it, or a delay; and for a force that went through a moving average, which is
    linear, so that the derivatives go through it too: only samples with whole windows count.
    """
    model, J = along_with_columns(problem.composition, piece.t, piece.x, piece.v, values, states)
    early = np.column_stack((J, model, np.ones(piece.t.size)))[:, source] * factor
    mine = source < len(problem.columns)
    if len(states) and values.ndim > 1:
        wide = np.ascontiguousarray(np.broadcast_to(factor, (factor.shape[0], source.size))[:, mine])
        arguments = (piece.t, piece.x, piece.v, values, states, source[mine], wide)
        early[:, mine] = along_with_laws(problem.composition, *arguments)[1]
    if by_lag is not None:
        early[:, source == problem.composition.lag] = by_lag[:, None]
    k, rows = problem.composition.delay, early
    if k is not None:
        slope = delayed_by_tau(piece.t, model, values[..., k])[:, None]
        rows = np.where(source == k, slope * factor, delayed(piece.t, early, values[..., k]))
        model = delayed(piece.t, model, values[..., k])
    weight = piece.weight
    if piece.average is not None:
        rows, model = averaged(rows, *piece.average), averaged(model, *piece.average)
        counts = np.zeros(piece.t.size)
        counts[piece.comparable] = 1.0
        weight = weight * counts
    table = weight[:, None] * np.column_stack((rows, force - gain * model))
    return np.stack([part.T @ part for part in np.split(table, ends[:-1])])


def with_priors(problem: Problem, point: SearchPoint, sums: Array) -> Array:
    """The sums (M, K, K) with the priors of gains and temperatures, as one more row each."""
    out = sums
    for name, spread in PRIOR.items():
        if name in problem.common:
            j, row = problem.common.index(name), np.zeros((len(problem.pieces), sums.shape[1]))
            # a sample that measures the logarithm as 0, with the prior's standard deviation; records weigh it by their misfit
            row[:, j] = MISFIT / spread
            row[:, -1] = -MISFIT / spread * point.local[:, j]
            out = out + row[:, :, None] * row[:, None, :]
    return out


def modelled_force(problem: Problem, point: SearchPoint, record: int) -> Array:
    """The force (n,) that the fit gives for a record, its own offset, gain and states included, N.

    Through the moving average of the measured force, where that holds one.
    """
    piece, values = problem.pieces[record], values_at(problem, point, record, input_at(problem, point, record))
    force = along(problem.composition, piece.t, piece.x, piece.v, values, point.states(problem, record))
    k = problem.composition.delay
    late = force if k is None else delayed(piece.t, force, np.asarray(values[..., k]))
    late = late if piece.average is None else averaged(late, *piece.average)
    return point.nuisance(problem, record, "offset") + point.nuisance(problem, record, "gain") * late


@dataclass(frozen=True)
class SearchStep:
    """Of the coefficients (G,) and of each record's nuisances (M, L)."""

    theta: Array
    local: Array


@dataclass(frozen=True)
class NormalEquations:
    """Sums of products (M, K, K) over [nuisances, coefficients, residual], and how far each unknown may step.

    Logarithmic coefficients step in their logarithm, by a factor of e at most.
    """

    sums: Array
    linear: Bools
    local_linear: Bools
    low: Array
    high: Array
    local_low: Array
    local_high: Array

    @cached_property
    def cost(self) -> float:
        """Half the sum of squares; NaN where the model could not be evaluated."""
        return float(compile_cached(half_sum_of_squares)(self.sums))

    @property
    def finite(self) -> bool:
        """Whether the model could be evaluated there."""
        return isfinite(self.cost)

    def reduction(self, step: SearchStep) -> float:
        """By how much a step lowers the cost, as the linear model has it."""
        return float(compile_cached(predicted_reduction)(self.sums, step.theta, step.local))

    def after(self, step: SearchStep) -> NormalEquations:
        """The normal equations after a step of unknowns that the force is affine in, the other derivatives as they are."""
        sums = np.empty_like(self.sums)
        compile_cached(sums_after_step)(self.sums, step.theta, step.local, sums)
        limits = (
            self.low - step.theta,
            self.high - step.theta,
            self.local_low - step.local,
            self.local_high - step.local,
        )
        return NormalEquations(sums, self.linear, self.local_linear, *limits)

    def _solve_one(self, only_linear: bool, damping: float, curvature: Array | None) -> SearchStep:
        """As `solve`, for one record: its nuisances are unknowns like the others."""
        L, S = self.local_low.shape[1], self.sums[0]
        if curvature is not None:
            H = S[:-1, :-1] + damping * np.diag(S.diagonal()[:-1])
            H, damping = with_curvature(H, np.pad(curvature, ((L, 0), (L, 0)))), 0.0
            S = np.column_stack((H, S[:-1, -1]))
        n = S.shape[1] - 1
        below, above, chosen = np.empty(n), np.empty(n), np.empty(n, dtype=bool)
        nuisances = self.local_low[0], self.local_high[0], self.local_linear
        row = only_linear, below, above, chosen
        compile_cached(unknowns_of_record)(self.low, self.high, self.linear, *nuisances, *row)
        step = solve_bounded(S, damping, below, above, chosen)
        return SearchStep(step[L:], step[None, :L])

    @cached_property
    def reduced(self) -> Eliminated:
        """The normal equations of the coefficients, every nuisance that is off its limits eliminated."""
        free = (self.local_low < -1e-12) & (self.local_high > 1e-12)
        return eliminated(self.sums, free, np.zeros_like(self.local_low))

    def _to_release(self, step: SearchStep, free: Bools, only_linear: bool) -> Bools:
        """Which nuisances are at a limit that they would leave to lower the cost."""
        if only_linear or np.all(free):
            return np.zeros_like(free)
        by_record = np.broadcast_to(step.theta, (len(self.sums), step.theta.size))
        d = np.concatenate((step.local, by_record), axis=1)
        slope = (self.sums[:, :-1, -1] - (self.sums[:, :-1, :-1] @ d[:, :, None])[:, :, 0])[:, : free.shape[1]]
        movable = self.local_high - self.local_low > 1e-12
        small = 1e-9 * np.abs(self.sums[:, :-1, -1][:, : free.shape[1]])
        off_low = (step.local <= self.local_low) & (slope > small)
        off_high = (step.local >= self.local_high) & (slope < -small)
        return ~free & movable & (off_low | off_high)

    def solve(self, only_linear: bool = False, damping: float = 0.0, curvature: Array | None = None) -> SearchStep:
        """The step to the lowest cost inside the limits, of all unknowns or of the linear ones.

        ``damping`` as in Levenberg-Marquardt, a part of each diagonal element; ``curvature`` (G, G) is added to the normal
        equations of the coefficients as far as it leaves them positive definite.
        """
        M, L = self.local_low.shape
        if M == 1:
            return self._solve_one(only_linear, damping, curvature)
        free = np.broadcast_to(self.local_linear | (not only_linear), (M, L)).copy()
        chosen = self.linear | (not only_linear)
        fixed = np.zeros((M, L))
        for turn in range(MAX_TURNS):
            left = eliminated(self.sums, free, fixed, damping)
            H = left.matrix + damping * np.diag(np.diag(left.matrix))
            H = with_curvature(H, curvature) if curvature is not None else H
            theta = solve_bounded(np.column_stack((H, left.target)), 0.0, self.low, self.high, chosen)
            local = left.nuisances(theta)
            beyond = (local < self.local_low) | (local > self.local_high)
            released = self._to_release(SearchStep(theta, local), free, only_linear) & (turn < MAX_TURNS // 2)
            if not np.any(beyond | released):
                break
            free = (free & ~beyond) | released
            fixed = np.where(free, 0.0, np.where(beyond, np.clip(local, self.local_low, self.local_high), fixed))
        return SearchStep(theta, np.clip(local, self.local_low, self.local_high))


@dataclass(frozen=True)
class Eliminated:
    """The normal equations of the coefficients alone, and how the nuisances follow."""

    matrix: Array
    target: Array
    own: Array
    by_theta: Array
    by_record: Array  # (M, G, G) of which ``matrix`` is the sum

    def nuisances(self, theta: Array) -> Array:
        """The nuisances' best step (M, L) for a step of the coefficients."""
        return np.asarray(self.own - self.by_theta @ theta)


def eliminated(sums: Array, free: Bools, fixed: Array, damping: float = 0.0) -> Eliminated:
    """The free nuisances (M, L) eliminated, the others stepping by ``fixed``."""
    L = free.shape[1]
    G = sums.shape[1] - L - 1
    b = sums[:, :-1, -1] - np.einsum("mij,mj->mi", sums[:, :-1, :L], fixed)
    diagonal = np.diagonal(sums, axis1=1, axis2=2)[:, :L]
    free = free & (diagonal > 1e-200)
    scale = np.where(free, 1.0 / np.sqrt(np.where(free, diagonal, 1.0)), 0.0)
    A = sums[:, :L, :L] * scale[:, :, None] * scale[:, None, :]
    # the row and the column of a nuisance that is not free are 0: with 1 on its diagonal its step comes out as 0
    A = A + np.eye(L) * np.where(free, damping + RIDGE, 1.0)[:, :, None]
    right = np.concatenate((sums[:, :L, L : L + G], b[:, :L, None]), axis=2) * scale[:, :, None]
    solved = np.linalg.solve(A, right) * scale[:, :, None] if L else right
    by_theta, constant = solved[:, :, :-1], solved[:, :, -1]
    across = sums[:, L : L + G, :L]
    by_record = sums[:, L : L + G, L : L + G] - across @ by_theta
    matrix = np.sum(by_record, axis=0)
    target = np.sum(b[:, L:] - np.einsum("mgl,ml->mg", across, constant), axis=0)
    return Eliminated(0.5 * (matrix + matrix.T), target, constant + fixed, by_theta, by_record)


def with_curvature(H: Array, curvature: Array) -> Array:
    """H with an estimate of the second derivatives, held between a fifth and ten times H in every direction."""
    d = np.sqrt(np.maximum(np.diag(H), 0.0))
    if not np.any(curvature) or np.any(d == 0.0):
        return H
    values, vectors = np.linalg.eigh(H / np.outer(d, d))
    # in the coordinates in which H is one: there the bounds hold in every direction alike
    root = vectors * np.sqrt(np.maximum(values, SINGULAR * values.max()))
    back = vectors / np.sqrt(np.maximum(values, SINGULAR * values.max()))
    seen, turned = np.linalg.eigh(back.T @ (curvature / np.outer(d, d)) @ back)
    full = root @ turned
    return np.asarray((full * np.clip(1.0 + seen, *CURVATURE_RANGE)) @ full.T * np.outer(d, d))


def linearise(problem: Problem, point: SearchPoint) -> NormalEquations:
    """The normal equations around ``point``."""
    return equations_from_sums(problem, point, with_priors(problem, point, np.concatenate(products(problem, point))))


def equations_from_sums(problem: Problem, point: SearchPoint, sums: Array) -> NormalEquations:
    """The normal equations of the sums of products (M, K, K) of each record around ``point``, which are changed in place."""
    below, above = np.empty((2, problem.size))
    compile_cached(to_search_coordinates)(sums, point.theta, problem.is_logarithmic, *problem.limits, below, above)
    low, high = problem.local_limits
    bounds = below, above, low - point.local, high - point.local
    return NormalEquations(sums, problem.is_linear, problem.is_local_linear, *bounds)


def step_point(problem: Problem, point: SearchPoint, step: SearchStep) -> SearchPoint:
    """``point`` after a step (a factor exp(step) of a logarithmic coefficient), inside the limits to rounding."""
    theta, local = np.empty(problem.size), np.empty_like(point.local)
    coefficients = point.theta, step.theta, problem.is_logarithmic, *problem.inner_limits, theta
    compile_cached(add_step)(*coefficients, point.local, step.local, *problem.local_limits, local)
    return SearchPoint(theta, local)


def half_sum_of_squares(sums: Array) -> float:
    """Half the sum of squared residuals; NaN where any of the sums is not finite."""
    total, seen = 0.0, 0.0
    for m in range(sums.shape[0]):
        total += sums[m, sums.shape[1] - 1, sums.shape[1] - 1]
        for i in range(sums.shape[1]):
            for j in range(sums.shape[1]):
                seen += 0.0 * sums[m, i, j]
    return 0.5 * total + seen


def predicted_reduction(sums: Array, theta: Array, local: Array) -> float:
    """By how much a step of (G,) coefficients and (M, L) nuisances lowers the cost, as the linear model has it."""
    L, G = local.shape[1], theta.size
    total = 0.0
    for m in range(sums.shape[0]):
        for i in range(L + G):
            d = local[m, i] if i < L else theta[i - L]
            slope = sums[m, i, L + G]
            for j in range(L + G):
                slope -= 0.5 * sums[m, i, j] * (local[m, j] if j < L else theta[j - L])
            total += d * slope
    return total


def sums_after_step(sums: Array, theta: Array, local: Array, out: Array) -> None:
    """The sums after such a step, where the derivatives stay."""
    L, G = local.shape[1], theta.size
    last = L + G
    for m in range(sums.shape[0]):
        total = sums[m, last, last]
        for i in range(last):
            step = 0.0
            for j in range(last):
                out[m, i, j] = sums[m, i, j]
                step += sums[m, i, j] * (local[m, j] if j < L else theta[j - L])
            total += (local[m, i] if i < L else theta[i - L]) * (step - 2.0 * sums[m, i, last])
            out[m, i, last] = out[m, last, i] = sums[m, i, last] - step
        out[m, last, last] = total


def to_search_coordinates(
    sums: Array, theta: Array, logarithmic: Bools, low: Array, high: Array, below: Array, above: Array
) -> None:
    """The sums by the logarithm of the logarithmic coefficients, in place, and how far each coefficient may step."""
    L = sums.shape[1] - theta.size - 1
    for k in range(theta.size):
        below[k], above[k] = low[k] - theta[k], high[k] - theta[k]
        if logarithmic[k]:
            below[k], above[k] = -1.0, min(1.0, log(max(high[k] / theta[k], 1.0)))
            for m in range(sums.shape[0]):
                for j in range(sums.shape[1]):
                    sums[m, L + k, j] *= theta[k]
                for j in range(sums.shape[1]):
                    sums[m, j, L + k] *= theta[k]


def unknowns_of_record(
    low: Array,
    high: Array,
    linear: Bools,
    local_low: Array,
    local_high: Array,
    local_linear: Bools,
    only_linear: bool,
    below: Array,
    above: Array,
    chosen: Bools,
) -> None:
    """The limits of a record's nuisances and of the coefficients in one row, and which of them a step may change."""
    L = local_low.size
    for i in range(below.size):
        nuisance = i < L
        below[i] = local_low[i] if nuisance else low[i - L]
        above[i] = local_high[i] if nuisance else high[i - L]
        chosen[i] = not only_linear or (local_linear[i] if nuisance else linear[i - L])


def add_step(
    theta: Array,
    step: Array,
    logarithmic: Bools,
    low: Array,
    high: Array,
    out: Array,
    local: Array,
    local_step: Array,
    local_low: Array,
    local_high: Array,
    local_out: Array,
) -> None:
    """Coefficients and nuisances after a step, inside their limits to rounding."""
    for m in range(local.shape[0]):
        for i in range(local.shape[1]):
            local_out[m, i] = min(max(local[m, i] + local_step[m, i], local_low[i]), local_high[i])
    for k in range(theta.size):
        moved = theta[k] * exp(step[k]) if logarithmic[k] else theta[k] + step[k]
        out[k] = min(max(moved, low[k]), high[k])


KERNELS = (
    half_sum_of_squares, predicted_reduction, sums_after_step, to_search_coordinates, unknowns_of_record, add_step,
)  # fmt: skip
