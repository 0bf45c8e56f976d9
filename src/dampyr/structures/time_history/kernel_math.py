"""Elementary operations of the time-stepping kernel: turning points, peaks, delayed forces, small dense matrices.

Plain Python, which :func:`dampyr.models.codegen.kernels.bind` compiles together with the kernel.
"""

from __future__ import annotations

import math
from typing import Any


def turning_point(x0: float, x1: float, v0: float, v1: float, dt: float) -> tuple[float, float]:
    """Where the cubic through both ends turns, for velocities of opposite sign: (fraction of dt, displacement)."""
    u0, u1 = v0 * dt, v1 * dt
    a = 3.0 * (u0 + u1) - 6.0 * (x1 - x0)
    b = 6.0 * (x1 - x0) - 4.0 * u0 - 2.0 * u1
    q = -0.5 * (b + math.copysign(math.sqrt(max(b * b - 4.0 * a * u0, 0.0)), b))
    s = u0 / q if q != 0.0 else 0.5
    if not 0.0 <= s <= 1.0:
        s = q / a
    s = min(max(s, 0.0), 1.0)
    return s, x0 + s * (u0 + s * (0.5 * b + s * a / 3.0))


def raise_peak(peaks: Any, k: int, x0: float, x1: float, v0: float, v1: float, dt: float) -> None:
    """Raise ``peaks[k]`` to the largest size of the displacement after its start, between the two ends too."""
    size = abs(x1)
    if v0 * v1 < 0.0:
        size = max(size, abs(turning_point(x0, x1, v0, v1, dt)[1]))
    if size > peaks[k]:
        peaks[k] = size


def quadratic(f0: float, fh: float, f1: float, s: float) -> float:
    """The quadratic through its values at 0, 1/2 and 1, at ``s``."""
    return f0 * (1.0 - s) * (1.0 - 2.0 * s) + 4.0 * fh * s * (1.0 - s) + f1 * s * (2.0 * s - 1.0)


def delayed_force(ring: Any, site: int, steps: float, rest: float) -> float:
    """The force at a time in the past, counted in steps from the start: the quadratic of its step, or the force at rest."""
    if steps <= 0.0:
        return rest
    k = math.floor(steps)
    n = ring.shape[1]
    return quadratic(ring[site, (2 * k) % n], ring[site, (2 * k + 1) % n], ring[site, (2 * k + 2) % n], steps - k)


def add_product(matrix: Any, vector: Any, result: Any) -> None:
    """Add ``matrix @ vector`` to ``result``."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            result[i] += matrix[i, j] * vector[j]


def copy_into(source: Any, target: Any, first: int) -> None:
    """Copy ``source`` into ``target`` from index ``first`` on."""
    for i in range(source.shape[0]):
        target[first + i] = source[i]


def multiply(matrix: Any, vector: Any, out: Any) -> None:
    """``out = matrix @ vector``, taking as much of the vector as the matrix has columns."""
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += matrix[i, j] * vector[j]
        out[i] = total


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
