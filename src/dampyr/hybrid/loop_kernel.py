"""The loop of a virtual hybrid test, sample by sample, as numba compiles it.

At sample k the numerical part is at its state, the plant at its own; both are read, the compensator sets the command, and both
go on to k + 1: the plant with the command held, the numerical part with the ground linear and the force held that was
measured ``delay`` samples before.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

ORDER = 4  # displacement and its first three differences
PHASE_LEAD, MODEL_BASED, KALMAN = 0, 1, 2
DIVERGED = 1.0  # m: far beyond any actuator; the run ends there


class Numerical(NamedTuple):
    """The numerical part: see `dampyr.hybrid.setup.numerical_step`."""

    states: Any  # (2n, 2n)
    ground: Any  # (2n, 2)
    force: Any  # (2n,)
    row: Any  # (n,): the specimen's displacement of the floors'
    delay: int
    z: Any  # (2n,)
    next: Any  # (2n,)
    forces: Any  # (delay + 2,): the latest first


class Plant(NamedTuple):
    """Actuator and specimen, sensors and converters."""

    states: Any  # (5, 5)
    command: Any  # (5,)
    max_force: float
    displacement_noise: float  # s.d.
    force_noise: float
    step: float  # V
    limit: float  # V
    displacement_scale: float  # V/m
    force_scale: float  # V/N
    p: Any  # (5,)


class CompensatorArrays(NamedTuple):
    """The compensator: see `dampyr.hybrid.compensators`; what a kind does not use is zeros."""

    kind: int
    linear: Any  # (5,): Kp, Ki dt/2, and b0, b1, a1 of the phase lead
    theta: Any  # (ORDER,)
    scale: Any  # (ORDER,): theta is in these
    gain: Any  # (ORDER,) of the model-based law, times dt
    covariance: Any  # (ORDER, ORDER) of theta/scale
    noise: float  # m2, of the Kalman filter's innovations
    lead: float  # samples
    extrapolation: float  # samples
    b: Any  # (5,) of the filter
    a: Any  # (5,)


class Memory(NamedTuple):
    """What the compensator remembers."""

    x: Any  # (4,): the latest displacements of the numerical part, before this one
    filtered: Any  # (3,): of the measured displacement
    measured_filter: Any  # (4,)
    command_filter: Any  # (4,)
    lead: Any  # (4,): input, output of the phase lead, integral, error


def run_loop(ground: Any, noise: Any, num: Any, plant: Any, law: Any, memory: Any, out: Any, thetas: Any) -> Any:
    """Fill ``out`` (n + 4, T): floors, true and measured displacement, command, force; ``thetas`` (T, ORDER) or (0, ORDER).

    ``ground`` (T,) m/s2, ``noise`` (2, T) standard normal. Returns the samples done, fewer than T where the loop diverged, and
    how many of them were at the actuator's greatest force.
    """
    samples, floors, size = ground.shape[0], num.row.shape[0], num.z.shape[0]
    at_limit = 0
    for k in range(samples):
        target = 0.0
        for i in range(floors):
            target += num.row[i] * num.z[i]
            out[i, k] = num.z[i]
        x, f = plant.p[3], plant.p[2]
        measured = convert(
            x + plant.displacement_noise * noise[0, k], plant.displacement_scale, plant.step, plant.limit
        )
        force = convert(f + plant.force_noise * noise[1, k], plant.force_scale, plant.step, plant.limit)
        if law.kind == PHASE_LEAD:
            wanted = phase_lead(target, measured, law, memory)
        else:
            wanted = inverse(target, law, memory)
        u = convert(wanted, plant.displacement_scale, plant.step, plant.limit)
        if law.kind != PHASE_LEAD:
            learn(u, measured, law, memory)
        out[floors, k], out[floors + 1, k], out[floors + 2, k], out[floors + 3, k] = x, measured, u, f
        if k < thetas.shape[0]:
            for i in range(ORDER):
                thetas[k, i] = law.theta[i]
        if not (abs(x) < DIVERGED and abs(target) < DIVERGED):
            return k, at_limit
        if k + 1 < samples:
            at_limit += advance(ground[k], ground[k + 1], force, u, num, plant, law.extrapolation, size)
    return samples, at_limit


def advance(a0: float, a1: float, force: float, u: float, num: Any, plant: Any, extrapolation: float, size: int) -> int:
    """Numerical part and plant to the next sample; 1 where the actuator is at its greatest force."""
    d = num.delay
    for i in range(d + 1, 0, -1):
        num.forces[i] = num.forces[i - 1]
    num.forces[0] = force
    held = num.forces[d] + extrapolation * (num.forces[d] - num.forces[d + 1])
    for i in range(size):
        total = num.ground[i, 0] * a0 + num.ground[i, 1] * a1 + num.force[i] * held
        for j in range(size):
            total += num.states[i, j] * num.z[j]
        num.next[i] = total
    for i in range(size):
        num.z[i] = num.next[i]
    p, m, c = plant.p, plant.states, plant.command
    p0, p1, p2, p3, p4 = p[0], p[1], p[2], p[3], p[4]
    for i in range(5):
        p[i] = m[i, 0] * p0 + m[i, 1] * p1 + m[i, 2] * p2 + m[i, 3] * p3 + m[i, 4] * p4 + c[i] * u
    if abs(plant.p[2]) <= plant.max_force:
        return 0
    plant.p[2] = math.copysign(plant.max_force, plant.p[2])
    return 1


def convert(value: float, scale: float, step: float, limit: float) -> float:
    """A quantity through a converter."""
    volts = min(max(value * scale, -limit), limit)
    return (math.floor(volts / step + 0.5) * step if step > 0.0 else volts) / scale


def phase_lead(target: float, measured: float, law: Any, memory: Any) -> float:
    """Phase lead of the target, then a PI controller of the error, both by Tustin's rule."""
    c, m = law.linear, memory.lead
    wanted = c[2] * target + c[3] * m[0] + c[4] * m[1]
    error = wanted - measured
    m[2] += c[1] * (error + m[3])
    m[0], m[1], m[3] = target, wanted, error
    return c[0] * error + m[2]


def inverse(target: float, law: Any, memory: Any) -> float:
    """The command that the model of the plant's inverse asks for, ``lead`` samples ahead."""
    x1, x2, x3, x4 = memory.x[0], memory.x[1], memory.x[2], memory.x[3]
    memory.x[0], memory.x[1], memory.x[2], memory.x[3] = target, x1, x2, x3
    d1, d2, d3 = target - x1, target - 2.0 * x1 + x2, target - 3.0 * (x1 - x2) - x3
    d4 = target - 4.0 * (x1 + x3) + 6.0 * x2 + x4
    t0, t1, t2, t3 = law.theta[0], law.theta[1], law.theta[2], law.theta[3]
    s0, s1, s2, s3 = law.scale[0], law.scale[1], law.scale[2], law.scale[3]
    wanted = t0 * s0 * target + t1 * s1 * d1 + t2 * s2 * d2 + t3 * s3 * d3
    return wanted + law.lead * (t0 * s0 * d1 + t1 * s1 * d2 + t2 * s2 * d3 + t3 * s3 * d4)


def lowpass(value: float, b: Any, a: Any, s: Any) -> float:
    """A filter of fourth order, transposed direct form II."""
    y = b[0] * value + s[0]
    s[0] = b[1] * value - a[1] * y + s[1]
    s[1] = b[2] * value - a[2] * y + s[2]
    s[2] = b[3] * value - a[3] * y + s[3]
    s[3] = b[4] * value - a[4] * y
    return y


def learn(u: float, measured: float, law: Any, memory: Any) -> None:
    """Improve the model with the command and the measured displacement, both filtered."""
    f1, f2, f3 = memory.filtered[0], memory.filtered[1], memory.filtered[2]
    f0 = lowpass(measured, law.b, law.a, memory.measured_filter)
    command = lowpass(u, law.b, law.a, memory.command_filter)
    memory.filtered[0], memory.filtered[1], memory.filtered[2] = f0, f1, f2
    p0, p1 = law.scale[0] * f0, law.scale[1] * (f0 - f1)
    p2, p3 = law.scale[2] * (f0 - 2.0 * f1 + f2), law.scale[3] * (f0 - 3.0 * (f1 - f2) - f3)
    t0, t1, t2, t3 = law.theta[0], law.theta[1], law.theta[2], law.theta[3]
    error = command - (t0 * p0 + t1 * p1 + t2 * p2 + t3 * p3)
    if law.kind == MODEL_BASED:
        share = error / (1.0 + p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
        law.theta[0] = max(0.0, t0 + law.gain[0] * share * p0)
        law.theta[1] = max(0.0, t1 + law.gain[1] * share * p1)
        law.theta[2] = max(0.0, t2 + law.gain[2] * share * p2)
        law.theta[3] = max(0.0, t3 + law.gain[3] * share * p3)
    else:
        kalman_update(error, p0, p1, p2, p3, law)


def kalman_update(error: float, p0: float, p1: float, p2: float, p3: float, law: Any) -> None:
    """One measurement update of a Kalman filter whose states are theta/scale; P is symmetric, its upper half is used."""
    P, t = law.covariance, law.theta
    g0 = P[0, 0] * p0 + P[0, 1] * p1 + P[0, 2] * p2 + P[0, 3] * p3
    g1 = P[0, 1] * p0 + P[1, 1] * p1 + P[1, 2] * p2 + P[1, 3] * p3
    g2 = P[0, 2] * p0 + P[1, 2] * p1 + P[2, 2] * p2 + P[2, 3] * p3
    g3 = P[0, 3] * p0 + P[1, 3] * p1 + P[2, 3] * p2 + P[3, 3] * p3
    share = 1.0 / (law.noise + p0 * g0 + p1 * g1 + p2 * g2 + p3 * g3)
    k0, k1, k2, k3 = share * g0, share * g1, share * g2, share * g3
    t[0], t[1], t[2], t[3] = t[0] + k0 * error, t[1] + k1 * error, t[2] + k2 * error, t[3] + k3 * error
    P[0, 0], P[0, 1], P[0, 2], P[0, 3] = P[0, 0] - k0 * g0, P[0, 1] - k0 * g1, P[0, 2] - k0 * g2, P[0, 3] - k0 * g3
    P[1, 1], P[1, 2], P[1, 3] = P[1, 1] - k1 * g1, P[1, 2] - k1 * g2, P[1, 3] - k1 * g3
    P[2, 2], P[2, 3], P[3, 3] = P[2, 2] - k2 * g2, P[2, 3] - k2 * g3, P[3, 3] - k3 * g3


def linear_history(states: Any, ground: Any, acceleration: Any, z: Any, following: Any, out: Any) -> None:
    """Displacements ``out`` (n, T) of a linear building under a ground acceleration (T,) linear between samples."""
    size = z.shape[0]
    for k in range(acceleration.shape[0]):
        for i in range(out.shape[0]):
            out[i, k] = z[i]
        if k + 1 < acceleration.shape[0]:
            for i in range(size):
                total = ground[i, 0] * acceleration[k] + ground[i, 1] * acceleration[k + 1]
                for j in range(size):
                    total += states[i, j] * z[j]
                following[i] = total
            for i in range(size):
                z[i] = following[i]


def lag_products(late: Any, early: Any, out: Any) -> None:
    """The sums of products (lags,) of two histories (T,), the second shifted by 0, 1, ... samples."""
    for lag in range(out.shape[0]):
        total = 0.0
        for k in range(early.shape[0] - lag):
            total += late[k + lag] * early[k]
        out[lag] = total


lag_products.reordered = True  # type: ignore[attr-defined]  # a sum whose order is free is eight times quicker
