r"""The kernel under control laws: as `dampyr.structures.time_stepping`, with inputs that change on the way.

A law decides at its own sampling instants, which are ends of steps, and holds its command between them. The input at the coil
follows at once, or as :math:`\tau \dot u = u_c - u`, whose exponential is known: the parameters of the dampers are
those at h/4 and 3h/4 along the halves of a step, and those at h/2 and h where the forces are taken.

What a damper remembers goes on where its parameters jump, so its force jumps with them: it is found again from the same
states, at the same motion, and the accelerations with it. The ground's velocity is the integral of its acceleration from 0.

``march`` is plain Python for numba; ``decide`` is a name that :func:`dampyr.models.codegen.kernels.bind` gives the laws.
"""

from __future__ import annotations

from typing import Any

from dampyr.models.laws import look_up
from dampyr.structures.kernel_math import solve
from dampyr.structures.time_stepping import finish, forecast, keep, observe, prepare, settle, store

BOUND_WITH = ("dampyr.structures.time_stepping", "dampyr.models.laws")


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it its dampers")


force = decide = _unbound


def sense(d: int, lin: Any, control: Any, now: Any, ground: float) -> tuple[float, float, float]:
    """The signal of a site's law, its stroke and its rate."""
    n = lin.pull.shape[0]
    signal, stroke, rate = control.gains[d, 2 * n] * ground, 0.0, 0.0
    for i in range(n):
        signal += control.gains[d, i] * now.z[i] + control.gains[d, n + i] * now.z[n + i]
        stroke += lin.connections[d, i] * now.z[i]
        rate += lin.connections[d, i] * now.z[n + i]
    return signal, stroke, rate


def govern(step: int, lin: Any, sites: Any, control: Any, w: Any, now: Any, ground: float) -> bool:
    """Let the laws decide where it is time, and set the parameters of the step; whether a force may jump."""
    jumped = False
    for d in range(control.every.shape[0]):
        every = control.every[d]
        if every > 0 and step % every == 0:
            signal, stroke, rate = sense(d, lin, control, now, ground)
            u = decide(control.kind[d], signal, stroke, rate, now.f[d], control.settings[d])
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
    return jumped


def jump(lin: Any, sites: Any, w: Any, now: Any) -> None:
    """The forces at the start of a step under its own parameters; where a damper has a mass, the accelerations answer."""
    n, count = lin.pull.shape[0], sites.delays.shape[0]
    for r in range(2 * count):
        w.residual[r] = 0.0
        for c in range(2 * count):
            w.jacobian[r, c] = 1.0 if r == c else 0.0
    for d in range(count):
        p, s, a = sites.params[d, 0], sites.states[d], w.y[5 * count + d]
        x, v = 0.0, 0.0
        for i in range(n):
            x += lin.connections[d, i] * now.z[i]
            v += lin.connections[d, i] * now.z[n + i]
        sites.inertance[d] = force(d, s, x, v, 1.0, p) - force(d, s, x, v, 0.0, p)
        if sites.delays[d] == 0.0:
            w.residual[d] = force(d, s, x, v, a, p) - now.f[d]
            for c in range(count):
                for i in range(n):
                    w.jacobian[d, c] -= sites.inertance[d] * lin.connections[d, i] * lin.acceleration[i, 2 * n + c]
    solve(w.jacobian, w.residual)
    for d in range(count):
        now.f[d] += w.residual[d]


def march(ag: Any, m: int, h: float, tolerance: float, lin: Any, sites: Any, control: Any, w: Any, out: Any) -> None:
    """March through the ground motion ``ag`` with m steps of h seconds per sample; ``out`` is written in place."""
    now, half, whole, work = w.now, w.half, w.whole, w.work
    ground = 0.0
    prepare(sites, w, now, h, out)
    observe(now, ag[0], lin, out)
    store(0, now, work, out)
    for d in range(control.level.shape[0]):
        out.input[0, d] = control.level[d]
    for i in range(ag.shape[0] - 1):
        for j in range(m):
            ag0 = ag[i] + (ag[i + 1] - ag[i]) * j / m
            ag1 = ag[i] + (ag[i + 1] - ag[i]) * (j + 1) / m
            if govern(i * m + j, lin, sites, control, w, now, ground):
                jump(lin, sites, w, now)
                observe(now, ag0, lin, out)
            forecast(lin, sites, w, now, ag0, ag1, i * m + j)
            settle(lin, sites, w, h, tolerance, out)
            finish(lin, sites, w, half, whole, i * m + j)
            observe(half, 0.5 * (ag0 + ag1), lin, out)
            observe(whole, ag1, lin, out)
            keep(now, half, 0.5 * h, out)
            keep(half, whole, 0.5 * h, out)
            for k in range(work.shape[0]):
                work[k] += h / 6.0 * (now.power[k] + 4.0 * half.power[k] + whole.power[k])
            ground += 0.5 * h * (ag0 + ag1)
            now, whole = whole, now
        store(i + 1, now, work, out)
        for d in range(control.level.shape[0]):
            out.input[i + 1, d] = control.level[d]
