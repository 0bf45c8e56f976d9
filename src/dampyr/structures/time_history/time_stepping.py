r"""The time-stepping kernel: a linear building and its dampers, step by step through a ground motion.

Over one step the building follows its exact propagator (:mod:`dampyr.structures.propagator`); every damper force
is the quadratic through its values at 0, h/2 and h. Those values are the dampers' own laws, followed along the path of the
step, so they are solved for by Newton's method with the dampers' own slopes. Where the stroke turns inside a half step, the
path is split at the turning point of the cubic through the displacements and velocities at both ends, because hysteresis is
integrated along monotone pieces.

A delayed damper pushes with the force that it would have given some time ago, interpolated from the quadratics of the past
steps; it needs no Newton iteration, but the step may not be longer than the delay.

Under control laws the inputs change on the way. A law decides at its own sampling instants, which are ends of steps, and holds
its command between them. The input at the coil follows at once, or as :math:`\tau \dot u = u_c - u`, an exact exponential:
the parameters of the dampers are those at h/4 and 3h/4 along the halves of a step, and those at h/2 and h where the forces are
taken. The states of a damper are continuous where its parameters jump, so its force jumps with them: it is computed again from
the same states, at the same motion, and the accelerations with it. The ground's velocity is the integral of its acceleration
from 0.

``integrate`` is plain Python for numba: ``advance``, ``force``, ``slopes``, ``decide`` and ``remember`` are names that
:func:`dampyr.models.codegen.kernels.bind` gives the functions of the dampers and of the laws. ``control`` is None where no law
sets an input, ``models`` where no law asks for a force (`dampyr.structures.wanted_force`), ``loads`` where nothing but the
ground pushes the building (`dampyr.structures.time_history.loading`); numba then leaves out everything that depends on it.
"""

from __future__ import annotations

import math
from typing import Any

from dampyr.models.laws import look_up
from dampyr.structures.sensor_noise import counter, normal_pair
from dampyr.structures.time_history.followed_model import follow, input_of_force
from dampyr.structures.time_history.kernel_math import (
    add_product,
    copy_into,
    delayed_force,
    multiply,
    raise_peak,
    solve,
    turning_point,
)

BOUND_WITH = (
    "dampyr.structures.time_history.kernel_math", "dampyr.structures.time_history.followed_model",
    "dampyr.models.laws", "dampyr.structures.sensor_noise",
)  # fmt: skip


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it its dampers")


advance = force = slopes = decide = remember = _unbound

MAX_ITERATIONS = 40  # of Newton's method in a step, which takes two or three: what has not converged by then never does
NEGLIGIBLE_FORCE = 1e-4  # of the largest force so far: smaller forces need not be solved to as many digits


def along(kind: int, s: Any, x0: float, x1: float, v0: float, v1: float, dt: float, p: Any, k: Any) -> None:
    """Advance a damper's states along half a step, in two pieces where it turns; k becomes (dF/dx1, dF/dv1)."""
    if v0 * v1 < 0.0:
        part, middle = turning_point(x0, x1, v0, v1, dt)
        advance(kind, s, x0, middle, v0, 0.0, part * dt, p)
        x0, v0, dt = middle, 0.0, (1.0 - part) * dt
    k[0], k[1] = slopes(kind, s, x0, x1, v0, v1, dt, p)
    advance(kind, s, x0, x1, v0, v1, dt, p)


def evaluate(sites: Any, work: Any, start: Any, y: Any, h: float, raw: Any, k: Any) -> None:
    """The damper laws over a step whose motion is y: forces ``raw`` (fh, f1), slopes ``k`` (2N, 2), states in ``work``."""
    n = sites.kind.shape[0]
    for d in range(n):
        kind, s, p = sites.kind[d], work[d], sites.params[d]
        copy_into(sites.states[d], s, 0)
        xh, vh, x1, v1 = y[d], y[n + d], y[3 * n + d], y[4 * n + d]
        along(kind, s, start[d], xh, start[n + d], vh, 0.5 * h, p[0], k[d])
        raw[d] = force(kind, s, xh, vh, y[2 * n + d], p[1])
        along(kind, s, xh, x1, vh, v1, 0.5 * h, p[2], k[n + d])
        raw[n + d] = force(kind, s, x1, v1, y[5 * n + d], p[3])


def correct(unknown: Any, raw: Any, k: Any, inertance: Any, delays: Any, g: Any, jacobian: Any, residual: Any) -> None:
    """One Newton correction of the forces g (fh, f1); the forces of delayed dampers stay as they are."""
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


def relative_residual(raw: Any, g: Any, delays: Any, scale: float) -> float:
    """The largest residual of the forces, relative to the largest of them (or to ``scale`` where that is larger)."""
    n = delays.shape[0]
    misfit, size = 0.0, scale
    for r in range(2 * n):
        if delays[r % n] == 0.0:
            size = max(size, abs(raw[r]))
            gap = abs(raw[r] - g[r])
            if not gap <= misfit:  # a NaN counts
                misfit = gap
    return misfit / size if misfit != 0.0 else 0.0


def set_loads(loads: Any, i: int, start: float, end: float) -> None:
    """The loads at both ends of a step, which lies from ``start`` to ``end`` of sample i."""
    count = loads.at.shape[0]
    for c in range(count):
        rise = loads.values[i + 1, c] - loads.values[i, c]
        loads.ends[c] = loads.values[i, c] + rise * start
        loads.ends[count + c] = loads.values[i, c] + rise * end


def observe(at: Any, ag: float, lin: Any, loads: Any, part: float, out: Any) -> None:
    """Compute absolute accelerations, drifts and powers at a node, and raise the peaks that are taken at nodes.

    The node is at ``part`` of the step whose loads are set.
    """
    n, sites = lin.pull.shape[0], at.f.shape[0]
    z = at.z
    copy_into(z, at.both, 0)
    copy_into(at.f, at.both, 2 * n)
    multiply(lin.acceleration, at.both, at.a)
    multiply(lin.drifts, z, at.q)
    shear, pull, viscous, loaded = lin.ground[n] * ag, 0.0, 0.0, 0.0
    if loads is not None:
        count = loads.at.shape[0]
        for c in range(count):
            loads.at[c] = loads.ends[c] + part * (loads.ends[count + c] - loads.ends[c])
            shear -= loads.shear[c] * loads.at[c]
            for i in range(n):
                loaded += loads.power[c, i] * z[n + i] * loads.at[c]
        add_product(loads.seen, loads.at, at.a)
    for i in range(n):
        at.a[i] += lin.ground[i] * ag
        shear += lin.pull[i] * at.a[i]
        pull -= lin.pull[i] * z[n + i]
        for j in range(n):
            viscous += z[n + i] * lin.damping[i, j] * z[n + j]
        out.acceleration_peak[i] = max(out.acceleration_peak[i], abs(at.a[i]))
    out.shear_peak[0] = max(out.shear_peak[0], abs(shear))
    at.power[0], at.power[1] = pull * ag + loaded, viscous
    for d in range(sites):
        rate = 0.0
        for i in range(n):
            rate += lin.connections[d, i] * z[n + i]
        at.power[2 + d] = at.f[d] * rate
        out.force_peak[d] = max(out.force_peak[d], abs(at.f[d]))


def raise_peaks(a: Any, b: Any, dt: float, out: Any) -> None:
    """Raise the peaks of displacement and drift over half a step."""
    n = out.displacement_peak.shape[0]
    for i in range(n):
        raise_peak(out.displacement_peak, i, a.z[i], b.z[i], a.z[n + i], b.z[n + i], dt)
        raise_peak(out.drift_peak, i, a.q[i], b.q[i], a.q[n + i], b.q[n + i], dt)


def store_sample(i: int, at: Any, work: Any, out: Any) -> None:
    """Write one sample of the output."""
    copy_into(at.z, out.state[i], 0)
    copy_into(at.a, out.acceleration[i], 0)
    copy_into(at.f, out.force[i], 0)
    copy_into(work, out.work[i], 0)


def initialise(sites: Any, w: Any, first: Any, h: float, out: Any) -> None:
    """Set the forces and slopes at rest, and the mass that each damper adds between its ends."""
    for d in range(sites.delays.shape[0]):
        kind, s, p = sites.kind[d], sites.states[d], sites.params[d, 3]
        w.rest[d] = force(kind, s, 0.0, 0.0, 0.0, p)
        sites.inertance[d] = force(kind, s, 0.0, 0.0, 1.0, p) - w.rest[d]
        fx, fv = slopes(kind, s, 0.0, 0.0, 0.0, 0.0, h, p)
        out.rest_slopes[d, 0], out.rest_slopes[d, 1] = fx, fv
        first.f[d] = w.rest[d]
        sites.ring[d, 0] = w.rest[d]


def predict(lin: Any, sites: Any, loads: Any, w: Any, now: Any, ag0: float, ag1: float, steps: int) -> None:
    """Compute all of a step that does not depend on its unknown forces; delayed forces are interpolated from the past."""
    n, count = lin.pull.shape[0], sites.delays.shape[0]
    copy_into(now.z, w.u, 0)
    w.u[2 * n], w.u[2 * n + 1] = ag0, ag1
    for d in range(count):
        w.u[2 * n + 2 + d] = now.f[d]
        for half in range(2):
            w.g[half * count + d] = now.f[d]
            if sites.delays[d] > 0.0:
                w.g[half * count + d] = delayed_force(
                    sites.ring, d, steps + 0.5 * (half + 1) - sites.delays[d], w.rest[d]
                )
        w.start[d], w.start[count + d] = 0.0, 0.0
        for i in range(n):
            w.start[d] += lin.connections[d, i] * now.z[i]
            w.start[count + d] += lin.connections[d, i] * now.z[n + i]
    multiply(lin.explicit, w.u, w.base)
    if loads is not None:
        add_product(loads.site, loads.ends, w.base)


def site_motion(unknown: Any, base: Any, g: Any, y: Any) -> None:
    """The motion of the sites under the forces g."""
    multiply(unknown, g, y)
    for i in range(y.shape[0]):
        y[i] += base[i]


def solve_forces(lin: Any, sites: Any, w: Any, h: float, tol: float, out: Any) -> None:
    """Solve for the forces of a step; a step that does not converge to the tolerance is counted, never passed over."""
    misfit, scale = 0.0, 0.0
    for d in range(sites.delays.shape[0]):
        scale = max(scale, NEGLIGIBLE_FORCE * out.force_peak[d])
    for _ in range(MAX_ITERATIONS):
        site_motion(lin.unknown, w.base, w.g, w.y)
        evaluate(sites, w.states, w.start, w.y, h, w.raw, w.slope)
        misfit = relative_residual(w.raw, w.g, sites.delays, scale)
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


def finish_step(lin: Any, sites: Any, loads: Any, w: Any, half: Any, whole: Any, steps: int) -> None:
    """Set the building at h/2 and h, and store the undelayed forces in the ring."""
    n, count = lin.pull.shape[0], sites.delays.shape[0]
    nodes = sites.ring.shape[1]
    for d in range(count):
        half.f[d], whole.f[d] = w.g[d], w.g[count + d]
        sites.ring[d, (2 * steps + 1) % nodes] = w.raw[d]
        sites.ring[d, (2 * steps + 2) % nodes] = w.raw[count + d]
    copy_into(w.g, w.u, 2 * n + 2 + count)
    multiply(lin.half, w.u, half.z)
    multiply(lin.whole, w.u, whole.z)
    if loads is not None:
        add_product(loads.half, loads.ends, half.z)
        add_product(loads.whole, loads.ends, whole.z)


def measure(d: int, number: int, lin: Any, control: Any, loads: Any, now: Any, ground: float, ag: float) -> None:
    """What the sensors of a site's law give at its sample ``number``."""
    n, known, y = lin.pull.shape[0], control.known, control.measured[d]
    copy_into(now.z, known, 0)
    known[2 * n], known[2 * n + 1] = ground, ag
    copy_into(now.f, known, 2 * n + 2)
    if loads is not None:
        first, count = 2 * n + 2 + now.f.shape[0], loads.at.shape[0]
        copy_into(loads.velocity, known, first)
        for c in range(count):
            known[first + count + c] = loads.ends[c]
    multiply(control.rows[d], known, y)
    if control.ideal[d]:
        return
    past, faults = control.past[d], control.faults[d]
    depth = past.shape[0]
    copy_into(y, past[number % depth], 0)
    for c in range(y.shape[0]):
        late = control.late[d, c]
        y[c] = past[(number - late) % depth, c] if number >= late else 0.0
        if faults[c, 0] > 0.0:
            channel = control.channels[d, c]
            pair = normal_pair(control.seed[d], counter(number, d, channel // 2))
            y[c] += faults[c, 0] * (pair[0] if channel % 2 == 0 else pair[1])
        y[c] = min(max(y[c] + faults[c, 1], -faults[c, 3]), faults[c, 3])
        if faults[c, 2] > 0.0:
            y[c] = faults[c, 2] * math.floor(y[c] / faults[c, 2] + 0.5)


def filtered(d: int, control: Any) -> None:
    """The arguments of a site's law: its signals from memory and measures, its states updated; then the next memory."""
    s, x, y = control.arguments[d], control.memory[d], control.measured[d]
    for j in range(control.signals[d]):
        s[j] = 0.0
        for k in range(x.shape[0]):
            s[j] += control.of_memory[d, j, k] * x[k]
        for c in range(y.shape[0]):
            s[j] += control.of_measured[d, j, c] * y[c]
    remember(control.kind[d], s, control.settings[d])
    for i in range(x.shape[0]):
        control.next_memory[i] = 0.0
        for k in range(x.shape[0]):
            control.next_memory[i] += control.F[d, i, k] * x[k]
        for c in range(y.shape[0]):
            control.next_memory[i] += control.G[d, i, c] * y[c]
    copy_into(control.next_memory, x, 0)


def decided(d: int, s: Any, control: Any, models: Any) -> float:
    """The input that a site's law decides on; of a law that asks for a force the one that the damper's model gives it with."""
    u = decide(control.kind[d], s, control.settings[d])
    if models is not None:  # noqa: SIM102 - alone, so that numba leaves out what it guards
        if models.asks[d] != 0:
            u = input_of_force(d, s, u, control, models)
    return u


def take_decision(d: int, number: int, control: Any, models: Any) -> float:
    """The decision of a site's law, stored with its arguments; one that is given in ``control.imposed`` is taken instead.

    Beside it is stored the decision farthest from it that the law could have taken, had each argument been off by as much as
    it differs from the run at twice the step (``control.before``): the law is a sign of something, so the corners tell.
    """
    s = control.arguments[d]
    sensed, count = control.sensed[d, number], control.count[d]
    if models is not None:  # noqa: SIM102 - alone, so that numba leaves out what it guards
        if models.asks[d] != 0:
            follow(d, s, control, models)
    u = decided(d, s, control, models)
    if models is not None:  # noqa: SIM102 - alone, so that numba leaves out what it guards
        if models.asks[d] != 0:
            models.tally[d, int(models.found[2])] += 1.0
    if number < control.imposed.shape[1] and control.imposed[d, number] == control.imposed[d, number]:
        u = control.imposed[d, number]
    copy_into(s, sensed, 0)
    sensed[s.shape[0]] = u
    if number < control.before.shape[1]:
        before = control.before[d, number]
        farthest = before[s.shape[0]]
        for corner in range(1 << count):
            for j in range(count):
                control.corner[j] = s[j] + (s[j] - before[j]) * (1.0 if (corner >> j) & 1 else -1.0)
            other = decided(d, control.corner, control, models)
            if abs(other - u) > abs(farthest - u):
                farthest = other
        control.other[d, number] = farthest
    return u


def update_inputs(
    step: int, lin: Any, sites: Any, control: Any, models: Any, loads: Any, now: Any, ground: float, ag: float
) -> bool:
    """Let the laws decide where it is time, and set the parameters of the step; True where a force may jump."""
    jumped = False
    for d in range(control.every.shape[0]):
        every = control.every[d]
        if every > 0 and step % every == 0:
            measure(d, step // every, lin, control, loads, now, ground, ag)
            filtered(d, control)
            u = take_decision(d, step // every, control, models)
            control.command[d] = u
            control.reached[d, 0] = min(control.reached[d, 0], u)
            control.reached[d, 1] = max(control.reached[d, 1], u)
        gap = control.level[d] - control.command[d]
        if every > 0 and gap != 0.0:
            for part in range(4):
                level = control.command[d] + gap * control.decay[d, part]
                look_up(control.knots[d], control.coefficients[d], level, sites.params[d, part])
            control.level[d] = control.command[d] + gap * control.decay[d, 3]
            jumped = jumped or control.decay[d, 0] == 0.0
        control.total[d] += control.command[d] + gap * control.mean_decay[d]
    return jumped


def apply_force_jump(lin: Any, sites: Any, w: Any, now: Any) -> None:
    """Set the forces at the start of a step under its own parameters, with the accelerations of dampers that have a mass."""
    n, count = lin.pull.shape[0], sites.delays.shape[0]
    for r in range(2 * count):
        w.residual[r] = 0.0
        for c in range(2 * count):
            w.jacobian[r, c] = 1.0 if r == c else 0.0
    for d in range(count):
        kind, s, p, a = sites.kind[d], sites.states[d], sites.params[d, 0], w.y[5 * count + d]
        x, v = 0.0, 0.0
        for i in range(n):
            x += lin.connections[d, i] * now.z[i]
            v += lin.connections[d, i] * now.z[n + i]
        sites.inertance[d] = force(kind, s, x, v, 1.0, p) - force(kind, s, x, v, 0.0, p)
        if sites.delays[d] == 0.0:
            w.residual[d] = force(kind, s, x, v, a, p) - now.f[d]
            for c in range(count):
                for i in range(n):
                    w.jacobian[d, c] -= sites.inertance[d] * lin.connections[d, i] * lin.acceleration[i, 2 * n + c]
    solve(w.jacobian, w.residual)
    for d in range(count):
        now.f[d] += w.residual[d]


def integrate(
    ag: Any,
    m: int,
    h: float,
    tolerance: float,
    lin: Any,
    sites: Any,
    control: Any,
    models: Any,
    loads: Any,
    w: Any,
    out: Any,
) -> None:
    """Integrate through the ground motion ``ag`` with m steps of h seconds per sample; ``out`` is written in place."""
    now, half, whole, work = w.now, w.half, w.whole, w.work
    ground = 0.0
    initialise(sites, w, now, h, out)
    if loads is not None:
        copy_into(loads.values[0], loads.ends, 0)
    observe(now, ag[0], lin, loads, 0.0, out)
    store_sample(0, now, work, out)
    if control is not None:
        copy_into(control.level, out.input[0], 0)
    for i in range(ag.shape[0] - 1):
        for j in range(m):
            ag0 = ag[i] + (ag[i + 1] - ag[i]) * j / m
            ag1 = ag[i] + (ag[i + 1] - ag[i]) * (j + 1) / m
            if loads is not None:
                set_loads(loads, i, j / m, (j + 1) / m)
            if control is not None:
                if update_inputs(i * m + j, lin, sites, control, models, loads, now, ground, ag0):
                    apply_force_jump(lin, sites, w, now)
                    observe(now, ag0, lin, loads, 0.0, out)
                ground += 0.5 * h * (ag0 + ag1)
                if loads is not None:
                    for c in range(loads.at.shape[0]):
                        loads.velocity[c] += 0.5 * h * (loads.ends[c] + loads.ends[loads.at.shape[0] + c])
            predict(lin, sites, loads, w, now, ag0, ag1, i * m + j)
            solve_forces(lin, sites, w, h, tolerance, out)
            finish_step(lin, sites, loads, w, half, whole, i * m + j)
            observe(half, 0.5 * (ag0 + ag1), lin, loads, 0.5, out)
            observe(whole, ag1, lin, loads, 1.0, out)
            raise_peaks(now, half, 0.5 * h, out)
            raise_peaks(half, whole, 0.5 * h, out)
            for k in range(work.shape[0]):
                work[k] += h / 6.0 * (now.power[k] + 4.0 * half.power[k] + whole.power[k])
            now, whole = whole, now
        store_sample(i + 1, now, work, out)
        if control is not None:
            copy_into(control.level, out.input[i + 1], 0)


integrate.vectorised = False  # type: ignore[attr-defined]  # its loops are over some floors and dampers
