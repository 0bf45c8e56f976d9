"""The small sums of the coupling kernel, for numba: turning points, peaks, past forces, dense matrices
of a few rows."""

from __future__ import annotations

import math
from typing import Any

from numba.extending import register_jitable


@register_jitable
def turning(x0: float, x1: float, v0: float, v1: float, dt: float) -> tuple[float, float]:
    """Where the cubic through both ends turns, for velocities of opposite sign: (fraction of dt,
    displacement)."""
    u0, u1 = v0 * dt, v1 * dt
    a = 3.0 * (u0 + u1) - 6.0 * (x1 - x0)
    b = 6.0 * (x1 - x0) - 4.0 * u0 - 2.0 * u1
    q = -0.5 * (b + math.copysign(math.sqrt(max(b * b - 4.0 * a * u0, 0.0)), b))
    s = u0 / q if q != 0.0 else 0.5
    if not 0.0 <= s <= 1.0:
        s = q / a
    s = min(max(s, 0.0), 1.0)
    return s, x0 + s * (u0 + s * (0.5 * b + s * a / 3.0))


@register_jitable
def put(source: Any, target: Any, first: int) -> None:
    """Copy ``source`` into ``target`` from index ``first`` on."""
    for i in range(source.shape[0]):
        target[first + i] = source[i]


@register_jitable
def times(matrix: Any, vector: Any, out: Any) -> None:
    """``out = matrix @ vector``, taking as much of the vector as the matrix has columns."""
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += matrix[i, j] * vector[j]
        out[i] = total


@register_jitable
def solve(a: Any, b: Any) -> None:
    """Solve ``a x = b`` by elimination with row exchange; both are overwritten, b holds x."""
    n = b.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        if best != k:
            for j in range(n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
            b[k], b[best] = b[best], b[k]
        for i in range(k + 1, n):
            factor = a[i, k] / a[k, k]
            for j in range(k + 1, n):
                a[i, j] -= factor * a[k, j]
            b[i] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]


@register_jitable
def past(ring: Any, site: int, steps: float, rest: float) -> float:
    """The force at a time in the past, counted in steps from the start: the quadratic of its step, or
    the force at rest."""
    if steps <= 0.0:
        return rest
    k = math.floor(steps)
    s = steps - k
    n = ring.shape[1]
    f0, fh, f1 = ring[site, (2 * k) % n], ring[site, (2 * k + 1) % n], ring[site, (2 * k + 2) % n]
    return f0 * (1.0 - s) * (1.0 - 2.0 * s) + 4.0 * fh * s * (1.0 - s) + f1 * s * (2.0 * s - 1.0)


@register_jitable
def peak(largest: Any, k: int, x0: float, x1: float, v0: float, v1: float, dt: float) -> None:
    """Keep the largest displacement of a half step, between its ends too."""
    size = abs(x1)
    if v0 * v1 < 0.0:
        size = max(size, abs(turning(x0, x1, v0, v1, dt)[1]))
    if size > largest[k]:
        largest[k] = size
