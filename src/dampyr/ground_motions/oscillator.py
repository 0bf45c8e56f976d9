r"""A linear oscillator on a shaking ground, exactly: the kernel of the response spectrum.

.. math:: \ddot u + 2\zeta\omega\dot u + \omega^2 u = -a_g(t), \qquad a_g \text{ linear between samples}

The state at the end of a step is a fixed linear map of the state at its start and of the two accelerations
([NigamJennings1969]_). Its coefficients are taken from the Taylor series of the solution instead of the closed form: that loses
no digits for long periods, where the closed form is a difference of nearly equal numbers, and holds for any damping, 1 and
more too. Steps longer than 0.4 / (omega (1 + 2 zeta)) are divided; the series, 15 terms, is then good to the last bit.

Peaks are those of the motion itself. Where a response turns inside a step and could exceed the peak so far, the instant is
found by Newton on the same series.

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
    cu: float, cv: float, u: float, v: float, p: float, slope: float, omega: float, zeta: float, h: float
) -> float:
    """The size of cu*u + cv*v where its rate is 0 inside a step; its rate has opposite signs at the two ends."""
    c, k = 2 * zeta * omega, omega * omega
    low, high = 0.0, h
    rising = cu * v + cv * (-p - c * v - k * u) > 0
    t = 0.5 * h
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
        if abs(nearer - t) <= 1e-9 * h:
            break
        t = nearer
    return abs(cu * x + cv * y)


def inside(
    cu: float, cv: float, u: float, v: float, u1: float, v1: float, p: float, slope: float,
    omega: float, zeta: float, h: float, peak: float,
) -> float:  # fmt: skip
    """The peak of |cu*u + cv*v| so far and inside a step from (u, v) to (u1, v1)."""
    c, k = 2 * zeta * omega, omega * omega
    rate0 = cu * v + cv * (-p - c * v - k * u)
    rate1 = cu * v1 + cv * (-(p + slope * h) - c * v1 - k * u1)
    size = max(abs(cu * u + cv * v), abs(cu * u1 + cv * v1))
    if rate0 * rate1 < 0 and size + h * max(abs(rate0), abs(rate1)) > peak:
        return max(peak, turning(cu, cv, u, v, p, slope, omega, zeta, h))
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
    u = v = most_u = most_v = most_a = 0.0
    for n in range(len(a) - 1):
        slope = (a[n + 1] - a[n]) / h
        for m in range(parts):
            p = a[n] + slope * (m * s)
            u1 = uu * u + uv * v + up * p + us * slope
            v1 = vu * u + vv * v + vp * p + vs * slope
            if not sampled:
                most_u = inside(1.0, 0.0, u, v, u1, v1, p, slope, omega, zeta, s, most_u)
                most_v = inside(0.0, 1.0, u, v, u1, v1, p, slope, omega, zeta, s, most_v)
                most_a = inside(k, c, u, v, u1, v1, p, slope, omega, zeta, s, most_a)
            u, v = u1, v1
            if not sampled or m == parts - 1:
                most_u, most_v, most_a = max(most_u, abs(u)), max(most_v, abs(v)), max(most_a, abs(k * u + c * v))
    peaks[0], peaks[1], peaks[2] = most_u, most_v, most_a
