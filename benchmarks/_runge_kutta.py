"""The building of chapter 5 by a loop of classical Runge-Kutta steps, one history after another, compiled by numba."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks._suite import Case
from dampyr.structures import state_space, two_storey

Array = NDArray[np.float64]


def peaks(cases: list[Case], m: int) -> Array:
    """(cases, 2): the peaks of the first floor and of the second storey's drift, with m steps to a sample."""
    march = compiled()
    matrices = state_space(two_storey())
    A, B, E = matrices.A, matrices.B[:, 0], matrices.E
    a, b, g = A[2:].copy(), float(B[2]), float(E[2])
    return np.array([march(case.acceleration, case.dt, m, *case.damper, a, b, g) for case in cases])


@lru_cache(maxsize=1)
def compiled() -> Callable[..., Any]:
    """The equations written out, scalars in registers, all liberties for the compiler; the ground linear between samples."""
    from numba import njit

    @njit(fastmath=True, error_model="numpy", inline="always")
    def rate(
        x1: float,
        x2: float,
        v1: float,
        v2: float,
        w: float,
        ground: float,
        kx: float,
        kw: float,
        rho: float,
        a: Any,
        b: float,
    ) -> Any:
        force = kx * v1 + kw * w
        a1 = a[0, 0] * x1 + a[0, 1] * x2 + a[0, 2] * v1 + a[0, 3] * v2 + b * force + ground
        a2 = a[1, 0] * x1 + a[1, 1] * x2 + a[1, 2] * v1 + a[1, 3] * v2 + ground
        return a1, a2, rho * (v1 - abs(v1) * w)

    @njit(fastmath=True, error_model="numpy")
    def march(
        acceleration: Any, dt: float, m: int, kx: float, kw: float, rho: float, a: Any, b: float, g: float
    ) -> tuple[float, float]:
        h, half, sixth = dt / m, 0.5 * dt / m, dt / m / 6.0
        x1 = x2 = v1 = v2 = w = floor = drift = 0.0
        for i in range(acceleration.size - 1):
            slope = (acceleration[i + 1] - acceleration[i]) / m
            for j in range(m):
                g0 = g * (acceleration[i] + slope * j)
                gh, g1 = g0 + 0.5 * g * slope, g0 + g * slope
                p1, q1, r1 = rate(x1, x2, v1, v2, w, g0, kx, kw, rho, a, b)
                s1, t1 = v1 + half * p1, v2 + half * q1
                p2, q2, r2 = rate(x1 + half * v1, x2 + half * v2, s1, t1, w + half * r1, gh, kx, kw, rho, a, b)
                s2, t2 = v1 + half * p2, v2 + half * q2
                p3, q3, r3 = rate(x1 + half * s1, x2 + half * t1, s2, t2, w + half * r2, gh, kx, kw, rho, a, b)
                s3, t3 = v1 + h * p3, v2 + h * q3
                p4, q4, r4 = rate(x1 + h * s2, x2 + h * t2, s3, t3, w + h * r3, g1, kx, kw, rho, a, b)
                x1, x2 = x1 + sixth * (v1 + 2.0 * (s1 + s2) + s3), x2 + sixth * (v2 + 2.0 * (t1 + t2) + t3)
                v1, v2 = v1 + sixth * (p1 + 2.0 * (p2 + p3) + p4), v2 + sixth * (q1 + 2.0 * (q2 + q3) + q4)
                w += sixth * (r1 + 2.0 * (r2 + r3) + r4)
                floor, drift = max(floor, abs(x1)), max(drift, abs(x2 - x1))
        return floor, drift

    return march
