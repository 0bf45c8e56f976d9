"""Bounded least squares: the minimum of s'Hs/2 - g's inside a box that holds 0, by an active set.

The loops are compiled by numba: a dozen unknowns are no work for a matrix library. The kernels make no arrays: what they need
comes with the call. Where Cholesky's factors show that H is near singular, the kernel returns, the step on the free unknowns
is taken by eigenvalues, and the kernel continues with it.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.kernels import compile_cached

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
PIVOT = 1e-6  # of Cholesky's factors of a matrix with ones on its diagonal: below it eigenvalues decide
MIN_GAP = 1e-12  # between two limits
SINGULAR = 1e-13  # of the largest eigenvalue of the scaled matrix: no step is taken along such a direction


def solve_bounded(S: Array, damping: float, low: Array, high: Array, chosen: Bools) -> Array:
    """The minimum over the ``chosen`` unknowns, the others staying at 0.

    ``S`` (n, n + 1) holds H and in its last column g; each diagonal element of H grows by ``damping`` of it.
    """
    n = chosen.size
    step, work, free = np.empty(n), np.empty((2 * n + 3, n)), np.empty(n, dtype=bool)
    kernel, resume = compile_cached(active_set), False
    for _ in range(10 * n + 10):
        if kernel(S, damping, low, high, chosen, work, free, step, resume):
            break
        H, residual, direction = work[:n], work[2 * n + 1], work[2 * n + 2]
        direction[:] = 0.0
        direction[free] = solve_by_eigenvalues(H[np.ix_(free, free)], residual[free])
        resume = True
    return step


def solve_by_eigenvalues(H: Array, g: Array) -> Array:
    """H^-1 g on the directions that are determined."""
    if g.size == 0:
        return np.zeros(0)
    d = H.diagonal()
    scale = np.where(d > 0, 1.0 / np.sqrt(np.where(d > 0, d, 1.0)), 0.0)
    values, vectors = np.linalg.eigh(H * scale * scale[:, None])
    determined = values > SINGULAR * max(float(values.max(initial=0.0)), 1e-300)
    weights = np.where(determined, 1.0 / np.where(determined, values, 1.0), 0.0)
    return np.asarray(scale * (vectors @ (weights * (vectors.T @ (scale * g)))))


def active_set(
    S: Array, damping: float, low: Array, high: Array, chosen: Bools, work: Array, free: Bools, s: Array, resume: bool
) -> bool:
    """The kernel of `solve_bounded`, one limit at a time; False where H is near singular on the ``free`` unknowns.

    ``work`` (2 n + 3, n) holds H, its factor, the scale, the residual g - H s and the direction of the next step. With
    ``resume`` it continues with the direction in ``work``.
    """
    n = s.size
    H, R, scale, residual, direction = work[:n], work[n : 2 * n], work[2 * n], work[2 * n + 1], work[2 * n + 2]
    largest = 0.0
    for i in range(n):
        if chosen[i]:
            largest = max(largest, abs(S[i, n]))
        if not resume:
            for j in range(n):
                H[i, j] = S[i, j]
            H[i, i] += damping * S[i, i]
            s[i] = 0.0
            free[i] = chosen[i] and max(high[i], 0.0) - min(low[i], 0.0) > MIN_GAP
    for _ in range(10 * n + 10):
        if not resume:
            set_residual(H, S, s, residual)
            if not solve_by_cholesky(H, residual, free, scale, R, direction):
                return False
        resume = False
        k = step_to_limit(low, high, free, s, direction)
        if k < 0:
            set_residual(H, S, s, residual)
            k = unknown_to_release(low, high, chosen, free, s, residual, largest)
            if k < 0:
                return True
            free[k] = True
    return True


def set_residual(H: Array, S: Array, s: Array, residual: Array) -> None:
    """residual = g - H s."""
    n = s.size
    for i in range(n):
        residual[i] = S[i, n]
        for j in range(n):
            residual[i] -= H[i, j] * s[j]


def solve_by_cholesky(H: Array, g: Array, free: Bools, scale: Array, R: Array, x: Array) -> bool:
    """x = H^-1 g on the free unknowns and 0 elsewhere; False where H is near singular."""
    n = g.size
    if not factorise(H, free, scale, R):
        return False
    for i in range(n):
        x[i] = 0.0
        if free[i]:
            total = scale[i] * g[i]
            for k in range(i):
                if free[k]:
                    total -= R[i, k] * x[k]
            x[i] = total / R[i, i]
    for i in range(n - 1, -1, -1):
        if free[i]:
            total = x[i]
            for k in range(i + 1, n):
                if free[k]:
                    total -= R[k, i] * x[k]
            x[i] = total / R[i, i]
    for i in range(n):
        if free[i]:
            x[i] *= scale[i]
    return True


def factorise(H: Array, free: Bools, scale: Array, R: Array) -> bool:
    """Cholesky's factor R of the free part of H, scaled to a diagonal of ones; False at a small pivot."""
    for i in range(scale.size):
        if not free[i]:
            continue
        if not H[i, i] > 0.0:
            return False
        scale[i] = 1.0 / sqrt(H[i, i])
        for j in range(i + 1):
            if free[j]:
                total = H[i, j] * scale[i] * scale[j]
                for k in range(j):
                    if free[k]:
                        total -= R[i, k] * R[j, k]
                if j < i:
                    R[i, j] = total / R[j, j]
                elif total > PIVOT:
                    R[i, i] = sqrt(total)
                else:
                    return False
    return True


def step_to_limit(low: Array, high: Array, free: Bools, s: Array, direction: Array) -> int:
    """Go the whole step (-1), or to the first limit: the index of the unknown that stops there, no longer free."""
    reach, k = 1.0, -1
    for i in range(s.size):
        limit = min(low[i], 0.0) if direction[i] < 0.0 else max(high[i], 0.0)
        if free[i] and direction[i] != 0.0 and abs(limit) < inf:
            part = max((limit - s[i]) / direction[i], 0.0)
            if part < reach:
                reach, k = part, i
    for i in range(s.size):
        s[i] += reach * direction[i]
    if k >= 0:
        s[k] = min(low[k], 0.0) if direction[k] < 0.0 else max(high[k], 0.0)
        free[k] = False
    return k


def unknown_to_release(
    low: Array, high: Array, chosen: Bools, free: Bools, s: Array, residual: Array, largest: float
) -> int:
    """The unknown at a limit that lowers the cost fastest by leaving it; -1 where there is none."""
    best, k = 1e-12 * largest, -1
    for i in range(s.size):
        if chosen[i] and not free[i] and max(high[i], 0.0) - min(low[i], 0.0) > MIN_GAP:
            slope = residual[i] if s[i] <= min(low[i], 0.0) else -residual[i]
            if slope > best:
                best, k = slope, i
    return k


KERNELS = (active_set, set_residual, solve_by_cholesky, factorise, step_to_limit, unknown_to_release)
