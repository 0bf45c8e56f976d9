"""Walking along a measured path: the force, and how it changes with every parameter.

The path is the polygon through the samples. Along each side the motion is monotone, so a part whose state depends on the
path alone is exact there, whatever the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.models.composition import Composition
from dampyr.models.kernels import bind

Array = NDArray[np.float64]


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.kernels.bind has given it a composition")


advance = force = columns = spread = _unbound


def march(t, x, v, a, p, s, out):  # type: ignore[no-untyped-def]
    """Fill ``out`` with the force along the path; ``p`` has one row, or one per sample."""
    last = p.shape[0] - 1
    out[0] = force(0, s, x[0], v[0], a[0], p[0])
    for i in range(1, t.size):
        q = p[min(i, last)]
        advance(0, s, x[i - 1], x[i], v[i - 1], v[i], t[i] - t[i - 1], q)
        out[i] = force(0, s, x[i], v[i], a[i], q)


def march_columns(t, x, v, a, p, s, D, out, J):  # type: ignore[no-untyped-def]
    """As `march`, and ``J[i]`` = the derivatives of the force by the parameters and the initial states."""
    last = p.shape[0] - 1
    out[0] = force(0, s, x[0], v[0], a[0], p[0])
    columns(0, s, D, x[0], v[0], a[0], p[0], J[0])
    for i in range(1, t.size):
        q = p[min(i, last)]
        spread(0, s, D, x[i - 1], x[i], v[i - 1], v[i], t[i] - t[i - 1], q)
        out[i] = force(0, s, x[i], v[i], a[i], q)
        columns(0, s, D, x[i], v[i], a[i], q, J[i])


def along(composition: Composition, t: Array, x: Array, v: Array, values: Array, state0: Array | None = None) -> Array:
    """The force in N along a path: t [s], x [m], v [m/s] of shape (n,), ``values`` (P,) or (n, P); not delayed."""
    out = np.empty(t.size)
    s = _start(composition, state0)
    bind(march, (composition,))(t, x, v, _acceleration(composition, t, v), _rows(values), s, out)
    return out


def along_with_columns(
    composition: Composition, t: Array, x: Array, v: Array, values: Array, state0: Array | None = None
) -> tuple[Array, Array]:
    """The force (n,) and its derivatives (n, P + S) by the P parameters and the S initial states; not delayed."""
    width = len(composition.parameters) + composition.n_states
    out, J = np.empty(t.size), np.zeros((t.size, width))
    s = _start(composition, state0)
    D = np.zeros((composition.n_states, width))
    for j in range(composition.n_states):
        D[j, len(composition.parameters) + j] = 1.0
    bind(march_columns, (composition,))(t, x, v, _acceleration(composition, t, v), _rows(values), s, D, out, J)
    return out, J


def _acceleration(composition: Composition, t: Array, v: Array) -> Array:
    """The acceleration by central differences of the velocity, or zeros where no part asks for it."""
    asked = any("a" in p.force.arguments for p in composition.parts if p.force)
    return np.asarray(np.gradient(v, t)) if asked else np.zeros_like(t)


def _start(composition: Composition, state0: Array | None) -> Array:
    return np.array(composition.state0 if state0 is None else state0, dtype=float)


def _rows(values: Array) -> Array:
    return np.ascontiguousarray(np.atleast_2d(values), dtype=float)


def delayed(t: Array, values: Array, tau: float | Array) -> Array:
    """``values`` (n,) or (n, k) as they were ``tau`` earlier, interpolated linearly; before the start, the first value."""
    if np.ndim(tau) == 0 and tau == 0.0:
        return values
    k, part, _ = _places(t, tau)
    if values.ndim == 2:
        part = part[:, None]
    return np.asarray(values[k] * (1.0 - part) + values[k + 1] * part)


def delayed_by_tau(t: Array, values: Array, tau: float | Array) -> Array:
    """The derivative of `delayed` (n,) by ``tau``; at a sample, where it has two, that of the longer delay."""
    k, _, inside = _places(t, tau)
    return np.asarray(np.where(inside, -(values[k + 1] - values[k]) / (t[k + 1] - t[k]), 0.0))


def _places(t: Array, tau: float | Array) -> tuple[NDArray[np.int64], Array, NDArray[np.bool_]]:
    """For each t - tau: the sample before it, how far towards the next it lies, and whether it lies after the start."""
    at = t - tau
    k = np.clip(np.searchsorted(t, at, side="left") - 1, 0, t.size - 2)
    part = np.clip((at - t[k]) / (t[k + 1] - t[k]), 0.0, 1.0)
    return k, part, at > t[0]
