r"""A linear oscillator on a shaking ground, exactly: the kernel of the response spectrum.

.. math:: \ddot u + 2\zeta\omega\dot u + \omega^2 u = -a_g(t), \qquad a_g \text{ linear between samples}

The state at the end of a step is a fixed linear map of the state at its start and of the two accelerations
([NigamJennings1969]_). Its coefficients are taken from the Taylor series of the solution instead of the closed form: that loses
no digits for long periods, where the closed form is a difference of nearly equal numbers, and holds for any damping, 1 and
more too. Steps longer than 0.4 / (omega (1 + 2 zeta)) are divided; the series, 15 terms, is then good to the last bit.

Peaks are those of the motion itself. Where a response turns inside a step and could exceed the peak so far, by a bound from its
rates at the two ends, the instant is found by Newton on the same series; turning and turning back within a step counts too.

References
----------
.. [NigamJennings1969] N. C. Nigam and P. C. Jennings, "Calculation of response spectra from strong-motion earthquake records",
   Bulletin of the Seismological Society of America 59(2), 909-922, 1969.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

REACH = 0.4
TERMS = 15


def substeps(omega: float, zeta: float, h: float) -> int:
    """How many equal parts of a step of ``h`` seconds the series needs."""
    return max(1, math.ceil(omega * (1 + 2 * zeta) * h / REACH))


def solution(u: float, v: float, p: float, slope: float, omega: float, zeta: float, t: float) -> tuple[float, float]:
    """Displacement and velocity ``t`` seconds after (u, v), the ground accelerating with p + slope*t."""
    c, k = 2 * zeta * omega, omega * omega
    x, y = u + v * t, v
    before, last = v, -p - c * v - k * u
    power, jerk = 1.0, slope
    for n in range(1, TERMS):
        power *= t / n
        y += last * power
        x += last * power * t / (n + 1)
        before, last = last, -jerk - c * last - k * before
        jerk = 0.0
    return x, y


def turning(
    cu: float, cv: float, u: float, v: float, p: float, slope: float, omega: float, zeta: float,
    low: float, high: float, rising: bool,
) -> float:  # fmt: skip
    """The size of y = cu*u + cv*v where it turns between ``low`` and ``high`` s into a step; ``rising``: y rises at ``low``."""
    c, k = 2 * zeta * omega, omega * omega
    least = 1e-9 * (high - low)
    t = 0.5 * (low + high)
    x, y = u, v
    for _ in range(60):
        x, y = solution(u, v, p, slope, omega, zeta, t)
        a = -(p + slope * t) - c * y - k * x
        rate = cu * y + cv * a
        bend = cu * a + cv * (-slope - c * a - k * y)
        if (rate > 0) == rising:
            low = t
        else:
            high = t
        nearer = t - rate / bend
        if not low < nearer < high:
            nearer = 0.5 * (low + high)
        if abs(nearer - t) <= least:
            break
        t = nearer
    return abs(cu * x + cv * y)


def inside(
    cu: float, cv: float, u: float, v: float, u1: float, v1: float, p: float, slope: float,
    omega: float, zeta: float, h: float, peak: float,
) -> float:  # fmt: skip
    """The peak of abs(cu*u + cv*v) so far and where it turns inside a step from (u, v) to (u1, v1), once or twice."""
    c, k = 2 * zeta * omega, omega * omega
    a, a1 = -p - c * v - k * u, -(p + slope * h) - c * v1 - k * u1
    rate, rate1 = cu * v + cv * a, cu * v1 + cv * a1
    if rate * rate1 < 0:
        return max(peak, turning(cu, cv, u, v, p, slope, omega, zeta, 0.0, h, rate > 0))
    bend, bend1 = cu * a + cv * (-slope - c * a - k * v), cu * a1 + cv * (-slope - c * a1 - k * v1)
    if rate * bend < 0 and rate1 * bend1 > 0:
        t = h * bend / (bend - bend1)
        x, y = solution(u, v, p, slope, omega, zeta, t)
        if (cu * y + cv * (-(p + slope * t) - c * y - k * x)) * rate < 0:
            peak = max(peak, turning(cu, cv, u, v, p, slope, omega, zeta, 0.0, t, rate > 0))
            peak = max(peak, turning(cu, cv, u, v, p, slope, omega, zeta, t, h, rate < 0))
    return peak


def march(a: Array, h: float, omegas: Array, zetas: Array, sampled: bool, peaks: Array) -> None:
    """Fill ``peaks`` (3, m, p): displacement, velocity (relative to the ground) and absolute acceleration of each oscillator.

    ``a`` (n,) ground acceleration, ``h`` its step, ``omegas`` (p,) rad/s, ``zetas`` (m,). ``sampled``: only the samples of the
    motion are looked at.
    """
    for i in range(len(zetas)):
        for j in range(len(omegas)):
            one(a, h, omegas[j], zetas[i], sampled, peaks[:, i, j])


def one(a: Array, h: float, omega: float, zeta: float, sampled: bool, peaks: Array) -> None:
    """One oscillator from rest through the whole motion."""
    parts = substeps(omega, zeta, h)
    s = h / parts
    uu, vu = solution(1.0, 0.0, 0.0, 0.0, omega, zeta, s)
    uv, vv = solution(0.0, 1.0, 0.0, 0.0, omega, zeta, s)
    up, vp = solution(0.0, 0.0, 1.0, 0.0, omega, zeta, s)
    us, vs = solution(0.0, 0.0, 0.0, 1.0, omega, zeta, s)
    c, k = 2 * zeta * omega, omega * omega
    u = v = max_u = max_v = max_a = 0.0
    b = -a[0]
    for n in range(len(a) - 1):
        slope = (a[n + 1] - a[n]) / h
        for m in range(parts):
            p = a[n] + slope * (m * s)
            u1 = uu * u + uv * v + up * p + us * slope
            v1 = vu * u + vv * v + vp * p + vs * slope
            b1 = -(p + slope * s) - c * v1 - k * u1
            if not sampled:
                jerk, jerk1 = -slope - c * b - k * v, -slope - c * b1 - k * v1
                if abs(u1) + s * (abs(v1) + s * (abs(b) + abs(b1))) > max_u:
                    max_u = inside(1.0, 0.0, u, v, u1, v1, p, slope, omega, zeta, s, max_u)
                if abs(v1) + s * (abs(b1) + s * (abs(jerk) + abs(jerk1))) > max_v:
                    max_v = inside(0.0, 1.0, u, v, u1, v1, p, slope, omega, zeta, s, max_v)
                bends = abs(k * b + c * jerk) + abs(k * b1 + c * jerk1)
                if abs(k * u1 + c * v1) + s * (abs(k * v1 + c * b1) + s * bends) > max_a:
                    max_a = inside(k, c, u, v, u1, v1, p, slope, omega, zeta, s, max_a)
            u, v, b = u1, v1, b1
            if not sampled or m == parts - 1:
                max_u, max_v, max_a = max(max_u, abs(u)), max(max_v, abs(v)), max(max_a, abs(k * u + c * v))
    peaks[0], peaks[1], peaks[2] = max_u, max_v, max_a
