r"""The kernel: a linear building and its dampers, step by step through a ground motion.

Over one step the building follows its exact propagator (:mod:`dampyr.structures.propagator`); every damper
force is the quadratic through its values at 0, h/2 and h. Those values are the dampers' own laws, followed
along the path of the step, so they are found by Newton's method with the dampers' own slopes. Where the
stroke turns round inside a half step, the path is split at the turning point of the cubic through the
displacements and velocities at both ends, because hysteresis is integrated along monotone pieces.

A delayed damper pushes with the force that it would have given some time ago, read off the quadratics of
the past steps; it needs no Newton, but the step may not be longer than the delay.

``march`` is plain Python for numba: ``advance``, ``force`` and ``slopes`` below are names that
:func:`dampyr.models.codegen.kernels.bind` gives the functions of the dampers.
"""

from __future__ import annotations

from typing import Any

from dampyr.structures.kernel_math import past, peak, put, solve, times, turning


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it its dampers")


advance = force = slopes = _unbound

MAX_ITERATIONS = 40
SMALL = 1e-4  # forces far below the largest so far need not be found to many digits


def along(site: int, s: Any, x0: float, x1: float, v0: float, v1: float, dt: float, p: Any, k: Any) -> None:
    """Take the states of a site along half a step, in two pieces where it turns; k becomes (dF/dx1,
    dF/dv1)."""
    if v0 * v1 < 0.0:
        part, middle = turning(x0, x1, v0, v1, dt)
        advance(site, s, x0, middle, v0, 0.0, part * dt, p)
        x0, v0, dt = middle, 0.0, (1.0 - part) * dt
    k[0], k[1] = slopes(site, s, x0, x1, v0, v1, dt, p)
    advance(site, s, x0, x1, v0, v1, dt, p)


def evaluate(states: Any, work: Any, start: Any, y: Any, h: float, params: Any, raw: Any, k: Any) -> None:
    """The damper laws over a step whose motion is y: forces ``raw`` (fh, f1), slopes ``k`` (2N, 2),
    states in ``work``."""
    n = states.shape[0]
    for d in range(n):
        s, p = work[d], params[d]
        put(states[d], s, 0)
        xh, vh, x1, v1 = y[d], y[n + d], y[3 * n + d], y[4 * n + d]
        along(d, s, start[d], xh, start[n + d], vh, 0.5 * h, p[0], k[d])
        raw[d] = force(d, s, xh, vh, y[2 * n + d], p[1])
        along(d, s, xh, x1, vh, v1, 0.5 * h, p[2], k[n + d])
        raw[n + d] = force(d, s, x1, v1, y[5 * n + d], p[3])


def correct(unknown: Any, raw: Any, k: Any, inertance: Any, delays: Any, g: Any, jacobian: Any, residual: Any) -> None:
    """One Newton correction of the forces g (fh, f1), the forces of delayed dampers being known."""
    n = inertance.shape[0]
    for r in range(2 * n):
        d = r % n
        row = d if r < n else 3 * n + d
        delayed = delays[d] > 0.0
        residual[r] = 0.0 if delayed else raw[r] - g[r]
        for c in range(2 * n):
            slope = k[r, 0] * unknown[row, c] + k[r, 1] * unknown[row + n, c] + inertance[d] * unknown[row + 2 * n, c]
            jacobian[r, c] = (1.0 if r == c else 0.0) - (0.0 if delayed else slope)
    solve(jacobian, residual)
    for r in range(2 * n):
        g[r] += residual[r]


def off_by(raw: Any, g: Any, delays: Any, scale: float) -> float:
    """The largest misfit of the forces, relative to the largest of them (or to ``scale`` when that is
    larger)."""
    n = delays.shape[0]
    misfit, size = 0.0, scale
    for r in range(2 * n):
        if delays[r % n] == 0.0:
            size = max(size, abs(raw[r]))
            gap = abs(raw[r] - g[r])
            if not gap <= misfit:  # a NaN counts
                misfit = gap
    return misfit / size if misfit != 0.0 else 0.0


def observe(at: Any, ag: float, lin: Any, out: Any) -> None:
    """Absolute accelerations, drifts and powers at a node, and the peaks that are taken at nodes."""
    n, sites = lin.pull.shape[0], at.f.shape[0]
    z = at.z
    put(z, at.both, 0)
    put(at.f, at.both, 2 * n)
    times(lin.acceleration, at.both, at.a)
    times(lin.drifts, z, at.q)
    shear, pull, viscous = 0.0, 0.0, 0.0
    for i in range(n):
        shear += lin.pull[i] * at.a[i]
        pull -= lin.pull[i] * z[n + i]
        for j in range(n):
            viscous += z[n + i] * lin.damping[i, j] * z[n + j]
        out.acceleration_peak[i] = max(out.acceleration_peak[i], abs(at.a[i]))
    out.shear_peak[0] = max(out.shear_peak[0], abs(shear))
    at.power[0], at.power[1] = pull * ag, viscous
    for d in range(sites):
        rate = 0.0
        for i in range(n):
            rate += lin.connections[d, i] * z[n + i]
        at.power[2 + d] = at.f[d] * rate
        out.force_peak[d] = max(out.force_peak[d], abs(at.f[d]))


def keep(a: Any, b: Any, dt: float, out: Any) -> None:
    """The peaks of displacement and drift over half a step."""
    n = out.displacement_peak.shape[0]
    for i in range(n):
        peak(out.displacement_peak, i, a.z[i], b.z[i], a.z[n + i], b.z[n + i], dt)
        peak(out.drift_peak, i, a.q[i], b.q[i], a.q[n + i], b.q[n + i], dt)


def store(i: int, at: Any, work: Any, out: Any) -> None:
    """One sample of the output."""
    put(at.z, out.state[i], 0)
    put(at.a, out.acceleration[i], 0)
    put(at.f, out.force[i], 0)
    put(work, out.work[i], 0)


def prepare(sites: Any, w: Any, first: Any, h: float, out: Any) -> None:
    """Forces and slopes at rest, and the mass that each damper adds between its ends."""
    for d in range(sites.delays.shape[0]):
        p = sites.params[d, 3]
        w.rest[d] = force(d, sites.states[d], 0.0, 0.0, 0.0, p)
        sites.inertance[d] = force(d, sites.states[d], 0.0, 0.0, 1.0, p) - w.rest[d]
        fx, fv = slopes(d, sites.states[d], 0.0, 0.0, 0.0, 0.0, h, p)
        out.rest_slopes[d, 0], out.rest_slopes[d, 1] = fx, fv
        first.f[d] = w.rest[d]
        sites.ring[d, 0] = w.rest[d]


def forecast(lin: Any, sites: Any, w: Any, now: Any, ag0: float, ag1: float, steps: int) -> None:
    """All of a step that is known before its forces are; delayed forces are read off the past."""
    n, count = lin.pull.shape[0], sites.delays.shape[0]
    put(now.z, w.u, 0)
    w.u[2 * n], w.u[2 * n + 1] = ag0, ag1
    for d in range(count):
        w.u[2 * n + 2 + d] = now.f[d]
        for half in range(2):
            w.g[half * count + d] = now.f[d]
            if sites.delays[d] > 0.0:
                w.g[half * count + d] = past(sites.ring, d, steps + 0.5 * (half + 1) - sites.delays[d], w.rest[d])
        w.start[d], w.start[count + d] = 0.0, 0.0
        for i in range(n):
            w.start[d] += lin.connections[d, i] * now.z[i]
            w.start[count + d] += lin.connections[d, i] * now.z[n + i]
    times(lin.explicit, w.u, w.base)


def move(unknown: Any, base: Any, g: Any, y: Any) -> None:
    """The motion of the sites under the forces g."""
    times(unknown, g, y)
    for i in range(y.shape[0]):
        y[i] += base[i]


def settle(lin: Any, sites: Any, w: Any, h: float, tol: float, out: Any) -> None:
    """Find the forces of a step; what is not found to the tolerance is counted, never passed over."""
    misfit, scale = 0.0, 0.0
    for d in range(sites.delays.shape[0]):
        scale = max(scale, SMALL * out.force_peak[d])
    for _ in range(MAX_ITERATIONS):
        move(lin.unknown, w.base, w.g, w.y)
        evaluate(sites.states, w.states, w.start, w.y, h, sites.params, w.raw, w.slope)
        misfit = off_by(w.raw, w.g, sites.delays, scale)
        out.misfit[2] += 1.0
        if misfit <= tol:
            break
        correct(lin.unknown, w.raw, w.slope, sites.inertance, sites.delays, w.g, w.jacobian, w.residual)
    if not misfit <= tol:
        out.misfit[0] += 1.0
        out.misfit[1] = max(out.misfit[1], misfit)
    for d in range(sites.states.shape[0]):
        for i in range(sites.states.shape[1]):
            sites.states[d, i] = w.states[d, i]


def finish(lin: Any, sites: Any, w: Any, half: Any, whole: Any, steps: int) -> None:
    """The building at h/2 and h, and the undelayed forces into the ring."""
    n, count = lin.pull.shape[0], sites.delays.shape[0]
    nodes = sites.ring.shape[1]
    for d in range(count):
        half.f[d], whole.f[d] = w.g[d], w.g[count + d]
        sites.ring[d, (2 * steps + 1) % nodes] = w.raw[d]
        sites.ring[d, (2 * steps + 2) % nodes] = w.raw[count + d]
    put(w.g, w.u, 2 * n + 2 + count)
    times(lin.half, w.u, half.z)
    times(lin.whole, w.u, whole.z)


def march(ag: Any, m: int, h: float, tolerance: float, lin: Any, sites: Any, w: Any, out: Any) -> None:
    """March through the ground motion ``ag`` with m steps of h seconds per sample; ``out`` is written
    in place."""
    now, half, whole, work = w.now, w.half, w.whole, w.work
    count = work.shape[0]
    prepare(sites, w, now, h, out)
    observe(now, ag[0], lin, out)
    store(0, now, work, out)
    for i in range(ag.shape[0] - 1):
        for j in range(m):
            ag0 = ag[i] + (ag[i + 1] - ag[i]) * j / m
            ag1 = ag[i] + (ag[i + 1] - ag[i]) * (j + 1) / m
            forecast(lin, sites, w, now, ag0, ag1, i * m + j)
            settle(lin, sites, w, h, tolerance, out)
            finish(lin, sites, w, half, whole, i * m + j)
            observe(half, 0.5 * (ag0 + ag1), lin, out)
            observe(whole, ag1, lin, out)
            keep(now, half, 0.5 * h, out)
            keep(half, whole, 0.5 * h, out)
            for k in range(count):
                work[k] += h / 6.0 * (now.power[k] + 4.0 * half.power[k] + whole.power[k])
            now, whole = whole, now
        store(i + 1, now, work, out)
