r"""The numerical substructure ahead of its time, and a specimen's model step by step; compiled with the model's formulas.

The structure is exact for a force that is held over a step. Ahead of what was measured the force is that of the model along the
set points that are sent already, plus the difference between the measured force and the model's, which is held; without a model
it is the measured force. Beyond the set points that are fixed, each new one is where the structure will be then: with the force
of the step's begin first, and once more with the mean of both ends.
"""

from __future__ import annotations

from typing import Any


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it a composition")


advance = force = _unbound


def follow_path(x, h, first, last, s, p, out):
    """The model's mean force over each step ``first`` to ``last`` of the path ``x``, straight between its points, into ``out``;
    ``s`` are its states at ``first``, and then at ``last``."""
    for j in range(first, last):
        v = (x[j + 1] - x[j]) / h
        begin = force(0, s, x[j], v, 0.0, p)
        advance(0, s, x[j], x[j + 1], v, v, h, p)
        out[j] = 0.5 * (begin + force(0, s, x[j + 1], v, 0.0, p))


def look_ahead(
    now,
    until,
    fixed,
    states,
    by_ground,
    by_force,
    row,
    ground,
    h,
    z,
    work,
    difference,
    modelled,
    path,
    rate,
    model,
    s,
    trial,
    p,
):
    """Extend ``path`` [m] and its ``rate`` [m/s] from index ``fixed`` to ``until``: where the structure will have it.

    ``z`` (2n,) is its state at index ``now``; ``model`` (T,) the model's mean force of each step, and ``s`` its states at
    ``fixed``, where ``modelled`` is true; ``difference`` [N] is added to it. ``work`` (2, 2n) and ``trial`` are overwritten.
    """
    n, here, there = row.size, work[0], work[1]
    put(z, here)
    for j in range(now, until):
        f = difference
        if modelled and j < fixed:
            f += model[j]
        elif modelled:
            v = rate[j]
            begin = force(0, s, path[j], v, 0.0, p)
            move(states, by_ground, by_force, here, ground[j], ground[j + 1], difference + begin, there)
            x = connection(row, there, 0)
            put(s, trial)
            w = (x - path[j]) / h
            advance(0, trial, path[j], x, w, w, h, p)
            f += 0.5 * (begin + force(0, trial, x, connection(row, there, n), 0.0, p))
        move(states, by_ground, by_force, here, ground[j], ground[j + 1], f, there)
        put(there, here)
        if j >= fixed:
            path[j + 1] = connection(row, here, 0)
            rate[j + 1] = connection(row, here, n)
            if modelled:
                follow_path(path, h, j, j + 1, s, p, model)


def force_now(x, v, s, p):
    """The model's force at this stroke and rate, its states being ``s``."""
    return force(0, s, x, v, 0.0, p)


def put(values, out):
    """Copy ``values`` into ``out``."""
    for k in range(values.size):
        out[k] = values[k]


def move(states, by_ground, by_force, z, a0, a1, f, out):
    """The structure's state after a step, into ``out``."""
    for i in range(z.size):
        value = by_ground[i, 0] * a0 + by_ground[i, 1] * a1 + by_force[i] * f
        for k in range(z.size):
            value += states[i, k] * z[k]
        out[i] = value


def connection(row, z, first):
    """The displacement (``first`` 0) or velocity (``first`` n) at the specimen."""
    value = 0.0
    for k in range(row.size):
        value += row[k] * z[first + k]
    return value
