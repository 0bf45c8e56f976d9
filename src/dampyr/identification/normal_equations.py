"""The normal equations around a point, each record's nuisances eliminated, and steps inside the limits.

Unknowns of one record meet those of another only through the coefficients, so a record's nuisances are eliminated from its
own sums (a Schur complement) and the joint problem is never larger than the coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from dampyr.identification import algebra
from dampyr.identification.gram import products, with_priors
from dampyr.identification.problem import Point, Problem
from dampyr.models.codegen.kernels import compile_cached

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
BLIND = 1e-13  # of the largest eigenvalue of the scaled normal equations: no step is taken along such a direction
MAX_TURNS = 12  # of letting nuisances go to their limits and back
RIDGE = 1e-13  # of each record's nuisances, so that two that say the same share their step


@dataclass(frozen=True)
class Step:
    """Of the coefficients (G,) and of each record's nuisances (M, L)."""

    theta: Array
    local: Array


@dataclass(frozen=True)
class Normal:
    """Sums of products (M, K, K) over [nuisances, coefficients, residual], and how far each unknown may step.

    Coefficients that are walked in their logarithm step in it, by a factor of e at most.
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
        """Half the sum of squares; no number where the model could not be evaluated."""
        return float(compile_cached(algebra.half_of_squares)(self.sums))

    @property
    def finite(self) -> bool:
        """Whether the model could be evaluated there."""
        return isfinite(self.cost)

    def gain(self, step: Step) -> float:
        """By how much a step lowers the cost, as the linear model has it."""
        return float(compile_cached(algebra.gained)(self.sums, step.theta, step.local))

    def after(self, step: Step) -> Normal:
        """What holds after a step of unknowns that the force is affine in, where the derivatives by the others stay."""
        sums = np.empty_like(self.sums)
        compile_cached(algebra.shifted)(self.sums, step.theta, step.local, sums)
        limits = (
            self.low - step.theta,
            self.high - step.theta,
            self.local_low - step.local,
            self.local_high - step.local,
        )
        return Normal(sums, self.linear, self.local_linear, *limits)

    def _solve_one(self, only_linear: bool, damping: float, curvature: Array | None) -> Step:
        """As `solve`, for one record: its nuisances are unknowns like the others."""
        L, S = self.local_low.shape[1], self.sums[0]
        if curvature is not None:
            H = S[:-1, :-1] + damping * np.diag(S.diagonal()[:-1])
            S, damping = np.column_stack((_bent(H, np.pad(curvature, ((L, 0), (L, 0)))), S[:-1, -1])), 0.0
        n = S.shape[1] - 1
        step, work, free = np.empty(n), np.empty((2 * n + 5, n)), np.empty((2, n), dtype=bool)
        limits = self.low, self.high, self.local_low[0], self.local_high[0]
        workspace = only_linear, work, free, step
        if not compile_cached(algebra.stepped_one)(S, damping, *limits, self.linear, self.local_linear, *workspace):
            step = by_eigenvalues(S, damping, work[2 * n + 3], work[2 * n + 4], free[1])
        return Step(step[L:], step[None, :L])

    @cached_property
    def reduced(self) -> Eliminated:
        """The normal equations of the coefficients, every nuisance that is off its limits eliminated."""
        free = (self.local_low < -1e-12) & (self.local_high > 1e-12)
        return eliminated(self.sums, free, np.zeros_like(self.local_low))

    def _inward(self, step: Step, free: Bools, only_linear: bool) -> Bools:
        """Which nuisances were stopped at a limit that the cost would rather have them leave."""
        if only_linear or np.all(free):
            return np.zeros_like(free)
        d = self._joined(step)
        slope = (self.sums[:, :-1, -1] - (self.sums[:, :-1, :-1] @ d[:, :, None])[:, :, 0])[:, : free.shape[1]]
        movable = self.local_high - self.local_low > 1e-12
        small = 1e-9 * np.abs(self.sums[:, :-1, -1][:, : free.shape[1]])
        off_low = (step.local <= self.local_low) & (slope > small)
        off_high = (step.local >= self.local_high) & (slope < -small)
        return ~free & movable & (off_low | off_high)

    def _joined(self, step: Step) -> Array:
        return np.concatenate((step.local, np.broadcast_to(step.theta, (len(self.sums), step.theta.size))), axis=1)

    def solve(self, only_linear: bool = False, damping: float = 0.0, curvature: Array | None = None) -> Step:
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
            H = _bent(H, curvature) if curvature is not None else H
            theta = np.zeros(self.low.size)
            theta[chosen] = bounded(H[np.ix_(chosen, chosen)], left.target[chosen], self.low[chosen], self.high[chosen])
            local = left.nuisances(theta)
            beyond = (local < self.local_low) | (local > self.local_high)
            inward = self._inward(Step(theta, local), free, only_linear) & (turn < MAX_TURNS // 2)
            if not np.any(beyond | inward):
                break
            free = (free & ~beyond) | inward
            fixed = np.where(free, 0.0, np.where(beyond, np.clip(local, self.local_low, self.local_high), fixed))
        return Step(theta, np.clip(local, self.local_low, self.local_high))


@dataclass(frozen=True)
class Eliminated:
    """The normal equations of the coefficients alone, and how the nuisances follow."""

    matrix: Array
    target: Array
    own: Array
    by_theta: Array

    def nuisances(self, theta: Array) -> Array:
        """The nuisances' best step (M, L) beside the coefficients' step."""
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
    A = A + np.eye(L) * np.where(free, damping + RIDGE, 1.0)[:, :, None]
    right = np.concatenate((sums[:, :L, L : L + G], b[:, :L, None]), axis=2) * scale[:, :, None]
    solved = np.linalg.solve(A, right) * scale[:, :, None] if L else right
    by_theta, own = solved[:, :, :-1], solved[:, :, -1]
    across = sums[:, L : L + G, :L]
    matrix = np.sum(sums[:, L : L + G, L : L + G] - across @ by_theta, axis=0)
    target = np.sum(b[:, L:] - np.einsum("mgl,ml->mg", across, own), axis=0)
    return Eliminated(0.5 * (matrix + matrix.T), target, own + fixed, by_theta)


def least(H: Array, g: Array) -> Array:
    """H^-1 g on the directions that are determined."""
    if g.size == 0:
        return np.zeros(0)
    d = H.diagonal()
    scale = np.where(d > 0, 1.0 / np.sqrt(np.where(d > 0, d, 1.0)), 0.0)
    values, vectors = np.linalg.eigh(H * scale * scale[:, None])
    seen = values > BLIND * max(float(values.max(initial=0.0)), 1e-300)
    weights = np.where(seen, 1.0 / np.where(seen, values, 1.0), 0.0)
    return np.asarray(scale * (vectors @ (weights * (vectors.T @ (scale * g)))))


def bounded(H: Array, g: Array, low: Array, high: Array) -> Array:
    """The minimum of s'Hs/2 - g's inside the box, which holds 0."""
    return within(np.column_stack((H, g)), 0.0, low, high, np.ones(g.size, dtype=bool))


def within(S: Array, damping: float, low: Array, high: Array, chosen: Bools) -> Array:
    """As `bounded`, of the ``chosen`` unknowns; H and g stand side by side in ``S``, each diagonal element grows by ``damping``
    of it."""
    n = chosen.size
    step, work, free = np.empty(n), np.empty((2 * n + 3, n)), np.empty(n, dtype=bool)
    workspace = work[:n], work[n : 2 * n], work[2 * n :]
    if compile_cached(algebra.stepped)(S, damping, low, high, chosen, *workspace, free, step):
        return step
    return by_eigenvalues(S, damping, low, high, chosen)


def by_eigenvalues(S: Array, damping: float, low: Array, high: Array, chosen: Bools) -> Array:
    """As `within`, where H is near singular."""
    n, some = chosen.size, np.flatnonzero(chosen)
    H = S[:n, :n] + damping * np.diag(S.diagonal()[:n])
    step = np.zeros(n)
    step[some] = _bounded(H[np.ix_(some, some)], S[some, n], low[some], high[some])
    return step


def _bounded(H: Array, g: Array, low: Array, high: Array) -> Array:
    """By eigenvalues: an active set, one limit at a time."""
    low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    s, free = np.zeros(g.size), high - low > 1e-12
    for _ in range(10 * g.size + 10):
        wanted = s.copy()
        wanted[free] += least(H[np.ix_(free, free)], (g - H @ s)[free])
        reach = _reach(s, wanted, low, high, free)
        k = int(np.argmin(reach)) if reach.size else -1
        if k >= 0 and reach[k] < 1.0:
            s = s + reach[k] * (wanted - s)
            s[k] = low[k] if wanted[k] < low[k] else high[k]
            free[k] = False
            continue
        s = wanted
        slope = np.where(free | (high - low <= 1e-12), 0.0, g - H @ s)
        inward = np.where(s <= low, slope, -slope)
        k = int(np.argmax(inward)) if inward.size else -1
        if k < 0 or inward[k] <= 1e-12 * float(np.max(np.abs(g), initial=0.0)):
            break
        free[k] = True
    return s


def _reach(s: Array, wanted: Array, low: Array, high: Array, free: Bools) -> Array:
    """Which part of the way to ``wanted`` each unknown can go."""
    way = wanted - s
    limit = np.where(way < 0, low, high)
    go = free & (way != 0.0) & np.isfinite(limit)
    return np.where(go, np.maximum((limit - s) / np.where(go, way, 1.0), 0.0), np.inf)


def _bent(H: Array, curvature: Array, least_part: float = 0.2, largest_part: float = 10.0) -> Array:
    """H with what is known of the second derivatives, held between a fifth and ten times H in every direction."""
    d = np.sqrt(np.maximum(np.diag(H), 0.0))
    if not np.any(curvature) or np.any(d == 0.0):
        return H
    values, vectors = np.linalg.eigh(H / np.outer(d, d))
    root = vectors * np.sqrt(np.maximum(values, BLIND * values.max()))
    back = vectors / np.sqrt(np.maximum(values, BLIND * values.max()))
    seen, turned = np.linalg.eigh(back.T @ (curvature / np.outer(d, d)) @ back)
    full = root @ turned
    return np.asarray((full * np.clip(1.0 + seen, least_part, largest_part)) @ full.T * np.outer(d, d))


def normal(problem: Problem, point: Point) -> Normal:
    """The linearised joint problem around ``point``."""
    sums = with_priors(problem, point, np.concatenate(products(problem, point)))
    below, above = np.empty((2, problem.size))
    compile_cached(algebra.walked)(sums, point.theta, problem.is_logarithmic, *problem.limits, below, above)
    low, high = problem.local_limits
    bounds = below, above, low - point.local, high - point.local
    return Normal(sums, problem.is_linear, problem.is_local_linear, *bounds)


def moved(problem: Problem, point: Point, step: Step) -> Point:
    """``point`` after a step (a factor exp(step) for what is walked in the logarithm), inside the limits to rounding."""
    theta, local = np.empty(problem.size), np.empty_like(point.local)
    given = point.theta, step.theta, problem.is_logarithmic, *problem.inner_limits, theta
    compile_cached(algebra.moved_to)(*given, point.local, step.local, *problem.local_limits, local)
    return Point(theta, local)
