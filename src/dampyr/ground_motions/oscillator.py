r"""Peaks of linear oscillators on a shaking ground, exactly: what response spectra are made of.

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

from dampyr.errors import InputError

Array = NDArray[np.float64]

STEP_LIMIT = 0.4  # of omega (1 + 2 zeta) h: so short that the terms below suffice
TERMS = 15  # of the Taylor series: 0.4^15/15! is below the last bit
MAX_PARTS = 20_000  # of a sample of the motion: a period of an oscillator that takes minutes is a mistake
MAX_DAMPING = 10.0  # ratio to critical: more is a damping in per cent


def oscillator_peaks(
    acceleration: Array, dt: float, periods: Array, damping: Array, sampled: bool = False
) -> tuple[Array, Array, Array, Array, Array]:
    """Peaks of displacement, velocity, absolute acceleration, pseudo-velocity and pseudo-acceleration, each (m, p).

    ``periods`` () or (p,) s, 0 for the rigid oscillator; ``damping`` () or (m,), ratios to critical. ``sampled``: only the
    samples of the motion are taken. Raises :class:`~dampyr.errors.InputError` for periods and dampings that make no sense.
    """
    from dampyr.models.codegen.kernels import compile_cached

    _check(periods, damping, dt)
    omega, pga = np.zeros_like(periods), float(np.max(np.abs(acceleration)))
    np.divide(2 * np.pi, periods, out=omega, where=periods > 0)
    omegas, zetas = np.array(omega, ndmin=1), np.array(damping, ndmin=1)
    peaks = np.zeros((3, len(zetas), len(omegas)))
    compile_cached(fill_peaks)(np.array(acceleration), dt, omegas, zetas, bool(sampled), peaks)
    peaks[:, :, np.atleast_1d(periods) == 0] = np.array([0.0, 0.0, pga])[:, None, None]
    d, v, a = (rows.reshape(damping.shape + periods.shape) for rows in peaks)
    return d, v, a, omega * d, np.where(periods > 0, omega**2 * d, pga)


def rotated_displacements(
    first: Array, second: Array, dt: float, periods: Array, damping: float, angles: Array
) -> Array:
    """Peaks of displacement (k, p) under the ground motions ``first`` cos + ``second`` sin of ``angles`` (k,) rad.

    ``periods`` (p,) s, ``damping`` a ratio to critical; checks and errors are those of `oscillator_peaks`.
    """
    from dampyr.models.codegen.kernels import compile_cached

    _check(periods, np.array(damping, dtype=float), dt)
    peaks = np.zeros((len(angles), len(periods)))
    omegas = np.zeros_like(periods)
    np.divide(2 * np.pi, periods, out=omegas, where=periods > 0)
    compile_cached(fill_rotated)(
        np.array(first), np.array(second), dt, omegas, float(damping), np.cos(angles), np.sin(angles), peaks
    )
    return peaks


def _check(T: Array, zeta: Array, dt: float) -> None:
    for name, values, unit in (("periods", T, " s"), ("damping", zeta, "")):
        if values.ndim > 1 or values.size == 0:
            raise InputError(f"{name} has shape {values.shape}; give a number or one row of at least 1 number")
        bad = values[~(np.isfinite(values) & (values >= 0))]
        if bad.size:
            raise InputError(f"{name}: {bad.flat[0]:g}{unit} is not allowed; it must be finite and at least 0")
    if zeta.max() > MAX_DAMPING:
        raise InputError(f"damping: {zeta.max():g} is not allowed; it is a ratio to critical, 0.05 for 5 %, at most 10")
    shortest = T[T > 0].min(initial=np.inf)
    least = 2 * np.pi * (1 + 2 * zeta.max()) * dt / (STEP_LIMIT * MAX_PARTS)
    if shortest < least:
        raise InputError(
            f"periods: {shortest:g} s is too short for samples every {dt:g} s; it must be 0 (rigid) or at least {least:.2g} s"
        )


def substeps(omega: float, zeta: float, h: float) -> int:
    """How many equal parts of a step of ``h`` seconds the series needs."""
    return max(1, math.ceil(omega * (1 + 2 * zeta) * h / STEP_LIMIT))


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


def turning_size(
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


def raise_peak_inside(
    cu: float, cv: float, u: float, v: float, u1: float, v1: float, p: float, slope: float,
    omega: float, zeta: float, h: float, peak: float,
) -> float:  # fmt: skip
    """The peak of abs(cu*u + cv*v) so far and where it turns inside a step from (u, v) to (u1, v1), once or twice."""
    c, k = 2 * zeta * omega, omega * omega
    a, a1 = -p - c * v - k * u, -(p + slope * h) - c * v1 - k * u1
    rate, rate1 = cu * v + cv * a, cu * v1 + cv * a1
    if rate * rate1 < 0:
        return max(peak, turning_size(cu, cv, u, v, p, slope, omega, zeta, 0.0, h, rate > 0))
    bend, bend1 = cu * a + cv * (-slope - c * a - k * v), cu * a1 + cv * (-slope - c * a1 - k * v1)
    if rate * bend < 0 and rate1 * bend1 > 0:
        t = h * bend / (bend - bend1)
        x, y = solution(u, v, p, slope, omega, zeta, t)
        if (cu * y + cv * (-(p + slope * t) - c * y - k * x)) * rate < 0:
            peak = max(peak, turning_size(cu, cv, u, v, p, slope, omega, zeta, 0.0, t, rate > 0))
            peak = max(peak, turning_size(cu, cv, u, v, p, slope, omega, zeta, t, h, rate < 0))
    return peak


def step_responses(
    omega: float, zeta: float, s: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Displacement and velocity after a step of ``s`` s from a unit displacement, velocity, acceleration and its slope."""
    uu, vu = solution(1.0, 0.0, 0.0, 0.0, omega, zeta, s)
    uv, vv = solution(0.0, 1.0, 0.0, 0.0, omega, zeta, s)
    up, vp = solution(0.0, 0.0, 1.0, 0.0, omega, zeta, s)
    us, vs = solution(0.0, 0.0, 0.0, 1.0, omega, zeta, s)
    return uu, vu, uv, vv, up, vp, us, vs


def fill_peaks(a: Array, h: float, omegas: Array, zetas: Array, sampled: bool, peaks: Array) -> None:
    """Fill ``peaks`` (3, m, p): displacement, velocity (relative to the ground) and absolute acceleration of each oscillator.

    ``a`` (n,) ground acceleration, ``h`` its step, ``omegas`` (p,) rad/s, ``zetas`` (m,). ``sampled``: only the samples of the
    motion are taken.
    """
    for i in range(len(zetas)):
        for j in range(len(omegas)):
            fill_one(a, h, omegas[j], zetas[i], sampled, peaks[:, i, j])


def fill_one(a: Array, h: float, omega: float, zeta: float, sampled: bool, peaks: Array) -> None:
    """One oscillator from rest through the whole motion."""
    parts = substeps(omega, zeta, h)
    s = h / parts
    uu, vu, uv, vv, up, vp, us, vs = step_responses(omega, zeta, s)
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
                    max_u = raise_peak_inside(1.0, 0.0, u, v, u1, v1, p, slope, omega, zeta, s, max_u)
                if abs(v1) + s * (abs(b1) + s * (abs(jerk) + abs(jerk1))) > max_v:
                    max_v = raise_peak_inside(0.0, 1.0, u, v, u1, v1, p, slope, omega, zeta, s, max_v)
                bends = abs(k * b + c * jerk) + abs(k * b1 + c * jerk1)
                if abs(k * u1 + c * v1) + s * (abs(k * v1 + c * b1) + s * bends) > max_a:
                    max_a = raise_peak_inside(k, c, u, v, u1, v1, p, slope, omega, zeta, s, max_a)
            u, v, b = u1, v1, b1
            if not sampled or m == parts - 1:
                max_u, max_v, max_a = max(max_u, abs(u)), max(max_v, abs(v)), max(max_a, abs(k * u + c * v))
    peaks[0], peaks[1], peaks[2] = max_u, max_v, max_a


def fill_rotated(
    a1: Array, a2: Array, h: float, omegas: Array, zeta: float, cosines: Array, sines: Array, peaks: Array
) -> None:
    """Fill ``peaks`` (k, p): the displacement of each oscillator under ``a1`` cos + ``a2`` sin, for k angles.

    An oscillator is linear: it is integrated once for each of the two accelerations, and the displacement at an angle is the
    same sum of the two. A step whose bound, whatever the angle, lies below the least peak so far is passed over.
    """
    for j in range(len(omegas)):
        omega = omegas[j]
        if omega == 0.0:
            continue
        parts = substeps(omega, zeta, h)
        s = h / parts
        uu, vu, uv, vv, up, vp, us, vs = step_responses(omega, zeta, s)
        c, k = 2 * zeta * omega, omega * omega
        x, v, y, w = 0.0, 0.0, 0.0, 0.0  # displacement and velocity of the first, of the second
        least = 0.0
        for n in range(len(a1) - 1):
            slope1, slope2 = (a1[n + 1] - a1[n]) / h, (a2[n + 1] - a2[n]) / h
            for m in range(parts):
                p, q = a1[n] + slope1 * (m * s), a2[n] + slope2 * (m * s)
                x1, v1 = uu * x + uv * v + up * p + us * slope1, vu * x + vv * v + vp * p + vs * slope1
                y1, w1 = uu * y + uv * w + up * q + us * slope2, vu * y + vv * w + vp * q + vs * slope2
                b, d = -p - c * v - k * x, -q - c * w - k * y
                b1, d1 = -(p + slope1 * s) - c * v1 - k * x1, -(q + slope2 * s) - c * w1 - k * y1
                rates = math.hypot(v1, w1) + s * (math.hypot(b, d) + math.hypot(b1, d1))
                if math.hypot(x1, y1) + s * rates > least:
                    least = np.inf
                    for i in range(len(cosines)):
                        e, f = cosines[i], sines[i]
                        u1, r1, peak = e * x1 + f * y1, e * v1 + f * w1, peaks[i, j]
                        if abs(u1) + s * (abs(r1) + s * (abs(e * b + f * d) + abs(e * b1 + f * d1))) > peak:
                            peak = raise_peak_inside(
                                1.0, 0.0, e * x + f * y, e * v + f * w, u1, r1, e * p + f * q,
                                e * slope1 + f * slope2, omega, zeta, s, peak,
                            )  # fmt: skip
                            peaks[i, j] = peak = max(peak, abs(u1))
                        least = min(least, peak)
                x, v, y, w = x1, v1, y1, w1
