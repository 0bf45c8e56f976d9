"""Integration along a measured path: the force, and its derivatives by every parameter.

The path is the polygon through the samples. Along each side the motion is monotone, so a part whose state depends on the
path alone is exact there, whatever the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.composition import Composition
from dampyr.models.codegen.kernels import bind

Array = NDArray[np.float64]


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it a composition")


BLOCK = 128  # samples whose columns are stored while their products are summed: a multiple of 8, to which counts are rounded up
advance = force = advance_tangents = jacobian = step_block = _unbound


def integrate_force(t, x, v, a, p, s, out):
    """Fill ``out`` with the force along the path; ``p`` has one row, or one per sample."""
    last = p.shape[0] - 1
    out[0] = force(0, s, x[0], v[0], a[0], p[0])
    for i in range(1, t.size):
        q = p[min(i, last)]
        advance(0, s, x[i - 1], x[i], v[i - 1], v[i], t[i] - t[i - 1], q)
        out[i] = force(0, s, x[i], v[i], a[i], q)


def integrate_jacobian(t, x, v, a, p, s, D, out, J):
    """As `integrate_force`, and ``J[i]`` = the derivatives of the force by the parameters and the initial states."""
    last = p.shape[0] - 1
    out[0] = force(0, s, x[0], v[0], a[0], p[0])
    jacobian(0, s, D, x[0], v[0], a[0], p[0], J[0])
    for i in range(1, t.size):
        q = p[min(i, last)]
        advance_tangents(0, s, D, x[i - 1], x[i], v[i - 1], v[i], t[i] - t[i - 1], q)
        out[i] = force(0, s, x[i], v[i], a[i], q)
        jacobian(0, s, D, x[i], v[i], a[i], q, J[i])


def sum_products(t, x, v, a, p, f, w, source, factor, gain, ends, s, D, workspace, rows, block, products):
    """Fill ``products[g]`` with the sums of products of all columns over the samples up to ``ends[g]``.

    A column of `integrate_jacobian`, or the force, or 1, is selected by ``source``, times ``factor`` and the weight ``w``; the
    last is the weighted residual, ``f`` less ``gain`` times the force. Only a block of samples is ever stored, each column
    contiguous in ``rows``.
    """
    first = 0
    for group in range(ends.size):
        while first < ends[group]:
            count = min(rows.shape[1], ends[group] - first)
            step_samples(first, count, t, x, v, a, p, s, D, workspace, rows)
            weigh_columns(first, count, rows, f, w, source, factor, gain, block)
            add_products(block, (count + 7) // 8 * 8, products[group])
            first += count
        symmetrise(products[group])


def step_samples(first, count, t, x, v, a, p, s, D, workspace, rows):
    """Step through ``count`` samples from ``first`` on: together where the parameters are constant, else one by one."""
    m = 0
    while m < count:
        at = first + m
        still = 1 if at == 0 else 0
        size = count - m if p.shape[0] == 1 and still == 0 else 1
        lo, hi = at - 1 + still, at + size + still
        q = p[min(at, p.shape[0] - 1)]
        step_block(0, still, t[lo:hi], x[lo:hi], v[lo:hi], a[lo:hi], q, s, D, workspace, rows[:, m:])
        m += size


def sum_products_delayed(t, x, v, a, p, f, w, source, factor, gain, ends, s, D, rows, block, products, k, tau, lo, hi):
    """As `sum_products` with everything ``tau`` later; ``k`` is the index of the derivative by tau."""
    first = j = 0
    step_to(0, t, x, v, a, p, s, D, lo)
    step_to(1, t, x, v, a, p, s, D, hi)
    for group in range(ends.size):
        while first < ends[group]:
            count = min(rows.shape[1], ends[group] - first)
            for m in range(count):
                at = t[first + m] - tau
                while t[j + 1] < at and j + 2 < t.size:
                    j += 1
                    for c in range(lo.size):
                        lo[c] = hi[c]
                    step_to(j + 1, t, x, v, a, p, s, D, hi)
                interpolate_row(t[j], t[j + 1], at, t[0], k, lo, hi, rows[:, m])
            weigh_columns(first, count, rows, f, w, source, factor, gain, block)
            add_products(block, (count + 7) // 8 * 8, products[group])
            first += count
        symmetrise(products[group])


def step_to(i, t, x, v, a, p, s, D, row):
    """Step to sample ``i``: its derivatives and, last but one, its force."""
    q = p[min(i, p.shape[0] - 1)]
    if i > 0:
        advance_tangents(0, s, D, x[i - 1], x[i], v[i - 1], v[i], t[i] - t[i - 1], q)
    row[row.size - 2] = force(0, s, x[i], v[i], a[i], q)
    jacobian(0, s, D, x[i], v[i], a[i], q, row)


def interpolate_row(t0, t1, at, start, k, lo, hi, row):
    """The row at the time ``at``, and the derivative of its force by the delay."""
    part = min(max((at - t0) / (t1 - t0), 0.0), 1.0)
    for c in range(row.size):
        row[c] = lo[c] + (hi[c] - lo[c]) * part
    last = row.size - 2
    row[k] = -(hi[last] - lo[last]) / (t1 - t0) if at > start else 0.0


def weigh_columns(first, count, rows, f, w, source, factor, gain, block):
    """The selected columns, and the residual, of ``count`` rows, each column contiguous; zeros after."""
    C, last, each = source.size, rows.shape[0] - 2, w.size > 1 or factor.shape[0] > 1
    for c in range(C):
        column, scale = source[c], w[0] * factor[0, c]
        for m in range(count):
            block[c, m] = scale * rows[column, m]
        if each:
            for m in range(count):
                scale = w[min(first + m, w.size - 1)] * factor[min(first + m, factor.shape[0] - 1), c]
                block[c, m] = scale * rows[column, m]
    here = f[first : first + count]
    for m in range(count):
        block[C, m] = w[0] * (here[m] - gain * rows[last, m])
    if w.size > 1:
        for m in range(count):
            block[C, m] = w[first + m] * (here[m] - gain * rows[last, m])
    for c in range(C + 1):
        for m in range(count, (count + 7) // 8 * 8):
            block[c, m] = 0.0


def add_products(block, full, total):
    """Add the products of a block's columns, two by two: each is read half as often."""
    last = total.shape[0] - 1
    for c in range(0, last + 1, 2):
        e = min(c + 1, last)
        for d in range(c, last + 1, 2):
            g = min(d + 1, last)
            cd, cg, ed, eg = 0.0, 0.0, 0.0, 0.0
            for m in range(full):
                cd += block[c, m] * block[d, m]
                cg += block[c, m] * block[g, m]
                ed += block[e, m] * block[d, m]
                eg += block[e, m] * block[g, m]
            total[c, d] += cd
            if g > d:
                total[c, g] += cg
            if e > c and d > c:
                total[e, d] += ed
            if e > c and g > d:
                total[e, g] += eg


def symmetrise(total):
    """Copy the upper triangle to the lower one."""
    for c in range(total.shape[0]):
        for d in range(c):
            total[c, d] = total[d, c]


add_products.reordered = True  # type: ignore[attr-defined]  # its sums may be vectorised


def products_along(
    composition: Composition,
    path: tuple[Array, Array, Array, Array],
    values: Array,
    state0: Array,
    force: Array,
    weight: Array,
    source: NDArray[np.int64],
    factor: Array,
    gain: float,
    ends: NDArray[np.int64],
) -> Array:
    """Sums of products of a record's columns and its residual, (groups, C + 1, C + 1), without storing the columns.

    ``path`` is t, x, v and the acceleration (see `acceleration`), ``force`` the measured force, ``weight`` (1,) or (n,).
    Column c is the derivative number ``source[c]`` (parameters, then initial states, then the force itself, then 1) times
    ``factor[:, c]`` (1 or n rows); the last is the residual ``force - gain * model``. ``ends`` are where groups of samples
    end. Delayed where the composition delays, which takes constant ``values``: one row.
    """
    P, S, C = len(composition.parameters), composition.n_states, source.size
    D, rows = np.eye(S, P + S, P), np.zeros((P + S + 2, BLOCK))
    rows[-1] = 1.0
    products, block, p = np.zeros((ends.size, C + 1, C + 1)), np.empty((C + 1, BLOCK)), _rows(values)
    given = (*path, p, force, weight, source, factor, gain, ends, _start(composition, state0), D)
    k = composition.delay
    if k is None:
        workspace = np.empty((composition.workspace_rows, BLOCK))
        bind(sum_products, (composition,))(*given, workspace, rows, block, products)
    else:
        lo = rows[:, 0].copy()
        bind(sum_products_delayed, (composition,))(*given, rows, block, products, k, float(p[0, k]), lo, lo.copy())
    return products


def integrate_law_jacobian(t, x, v, a, p, source, factor, s, saved, D, none, out, row, base, J):
    """Fill ``J[i, c]`` with the derivative by a coefficient that moves parameter ``source[c]`` by ``factor[i, c]``.

    The tangent of a state is linear in what it was and in the parameter's share of the piece; ``none`` holds that share, from
    a step with zero tangents at its start, and each coefficient takes ``factor`` of it at the input of that step.
    """
    last, S = source.size, s.size
    for i in range(t.size):
        q, f = p[min(i, p.shape[0] - 1)], factor[min(i, factor.shape[0] - 1)]
        for c in range(-1, last if i > 0 else -1):
            for j in range(S):
                if c < 0:
                    saved[j] = s[j]
                s[j] = saved[j]
            here = D[c] if c >= 0 else none
            advance_tangents(0, s, here, x[i - 1], x[i], v[i - 1], v[i], t[i] - t[i - 1], q)
            for j in range(S):
                if c >= 0:
                    D[c, j, source[c]] += (f[c] - 1.0) * none[j, source[c]]
        out[i] = force(0, s, x[i], v[i], a[i], q)
        for j in range(S):
            for k in range(none.shape[1]):
                none[j, k] = 0.0
        jacobian(0, s, none, x[i], v[i], a[i], q, base)
        for c in range(last):
            jacobian(0, s, D[c], x[i], v[i], a[i], q, row)
            J[i, c] = row[source[c]] + (f[c] - 1.0) * base[source[c]]


def along_with_laws(
    composition: Composition, t: Array, x: Array, v: Array, values: Array, state0: Array, source: Any, factor: Array
) -> tuple[Array, Array]:
    """The force (n,) and its derivatives (n, C) by coefficients of laws whose input varies along the path; not delayed.

    Coefficient c moves the parameter ``source[c]`` by ``factor[i, c]`` at sample i: the states depend on all earlier ones.
    """
    P, S, C = len(composition.parameters), composition.n_states, source.size
    D, none, saved = np.zeros((C, S, P + S)), np.zeros((S, P + S)), np.zeros(S)
    out, row, base, J = np.empty(t.size), np.zeros(P + S), np.zeros(P + S), np.zeros((t.size, C))
    given = (t, x, v, acceleration(composition, t, v), _rows(values), source, factor, _start(composition, state0))
    bind(integrate_law_jacobian, (composition,))(*given, saved, D, none, out, row, base, J)
    return out, J


def along(composition: Composition, t: Array, x: Array, v: Array, values: Array, state0: Array | None = None) -> Array:
    """The force in N along a path: t [s], x [m], v [m/s] of shape (n,), ``values`` (P,) or (n, P); not delayed."""
    out = np.empty(t.size)
    s = _start(composition, state0)
    bind(integrate_force, (composition,))(t, x, v, acceleration(composition, t, v), _rows(values), s, out)
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
    bind(integrate_jacobian, (composition,))(t, x, v, acceleration(composition, t, v), _rows(values), s, D, out, J)
    return out, J


def acceleration(composition: Composition, t: Array, v: Array) -> Array:
    """The acceleration by central differences of the velocity, or zeros where no part needs it."""
    needed = any(p.needs_acceleration for p in composition.parts)
    return np.asarray(np.gradient(v, t)) if needed else np.zeros_like(t)


def _start(composition: Composition, state0: Array | None) -> Array:
    return np.array(composition.path0 if state0 is None else state0, dtype=float)


def _rows(values: Array) -> Array:
    return np.ascontiguousarray(values if values.ndim > 1 else values[None], dtype=float)


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
