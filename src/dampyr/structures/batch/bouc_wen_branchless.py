r"""The Bouc-Wen state along a monotone path, in lanes: without branches or loops, to 2e-5 where damper and shape are usual.

`dampyr.models.numerics.bouc_wen_exact` is exact for every shape, by series whose lengths differ from history to history.
Here the same two phases are integrals by Gauss and Legendre, and their inverses two corrections of a good guess.

On the side y < 0, with u = -y, the way to u = 0 is the integral of :math:`1/(1 + c u^n)`, with six nodes in the square root of
u. Where the path ends before, the cubic that meets u and its rates at both ends of that way is the guess, and one correction of
third order follows. On the side y > 0,

.. math:: \int \frac{du}{1-u^n} = \tau + \int H\,du, \qquad d\tau = \frac{du}{(1-u)(1+(n-1)u)}, \qquad
          H = \frac{1}{1-u^n} - \frac{1}{(1-u)(1+(n-1)u)}

where H is bounded, and 0 for n = 1 and n = 2. The guess is the state after :math:`\tau = \xi`, which is elementary; two of
Newton's corrections by H follow.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import exp, log, sqrt

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.composition import Composition
from dampyr.models.codegen.formula import read

Array = NDArray[np.float64]
#: part -> parameter -> where the branch-free step was measured to hold; beyond, and in other parts, the exact one runs
USUAL: dict[str, dict[str, tuple[float, float]]] = {"bouc_wen": {"n": (1.0, 3.0), "sigma": (0.35, 1.25)}}
CALLERS = ("bouc_wen", "modified_bouc_wen")  # parts that walk along `dampyr.models.numerics.bouc_wen_exact`
NOWHERE = {"n": (np.inf, -np.inf)}

NEAR = 1e-3  # of y = 1: closer, H is what it is there
NOTHING = 1e-30
_nodes, _weights = np.polynomial.legendre.leggauss(6)
_roots = 0.5 * (1.0 + _nodes)  # of u, which is from 0 to 1
A1, A2, A3, A4, A5, A6 = (float(a) for a in 2.0 * np.log(_roots))
U1, U2, U3, U4, U5, U6 = (float(w) for w in _weights * _roots)
_nodes, _weights = np.polynomial.legendre.leggauss(5)
B1, B2, V0, V1, V2 = (float(b) for b in (*_nodes[:-3:-1], *_weights[2::-1]))
D1 = 1.0 / sqrt(3.0)


def power(u: float, n: float) -> float:
    return exp(n * log(max(u, NOTHING)))


def pair(a: float, b: float, c: float, d: float) -> float:
    """a/b + c/d with one division."""
    return (a * d + c * b) / (b * d)


def way_back(z: float, n: float, c: float) -> float:
    """The path from u to 0 in units of u, with z = c u**n."""
    first = pair(U1, 1.0 + z * exp(n * A1), U2, 1.0 + z * exp(n * A2))
    second = pair(U3, 1.0 + z * exp(n * A3), U4, 1.0 + z * exp(n * A4))
    return first + second + pair(U5, 1.0 + z * exp(n * A5), U6, 1.0 + z * exp(n * A6))


def unloading_step(u: float, way: float, walked: float, n: float, speed: float, c: float) -> float:
    """u after a path shorter than the ``way`` to 0, which begins at ``speed``."""
    t = walked / max(way, NOTHING)
    more = 1.0 - t
    guess = more * more * (u * (1.0 + t + t) - speed * walked) + walked * t * more
    near = min(max(guess, 0.0), u)
    z = c * power(near, n)
    missed = (way - walked) - near * way_back(z, n, c)
    moved = (1.0 + z) * missed
    return min(max(near + moved * (1.0 + 0.5 * n * z * missed / max(near, NOTHING)), 0.0), u)


def complement(v: float, m: float, tau: float, n: float) -> float:
    """1 - y after tau from 1 - y = v, with m = 1 + (n - 1) y."""
    e = v * exp(-n * tau)
    return n * e / (m + (n - 1.0) * e)


def steady(v: float, n: float) -> float:
    """(1 - u)(1 + (n - 1) u) where v = 1 - u."""
    return v * (n - (n - 1.0) * v)


def exact_rate(v: float, n: float) -> float:
    """1 - u**n where v = 1 - u."""
    return 1.0 - power(1.0 - v, n)


def rate_ratio_pair(r: float, s: float, n: float) -> float:
    """u H/sqrt(u) at two square roots of u, together."""
    v = max(1.0 - r * r, NEAR)
    a, b = exact_rate(v, n), steady(v, n)
    w = max(1.0 - s * s, NEAR)
    d, e = exact_rate(w, n), steady(w, n)
    return pair(r * (b - a), a * b, s * (e - d), d * e)


def rate_ratio(r: float, n: float) -> float:
    v = max(1.0 - r * r, NEAR)
    a, b = exact_rate(v, n), steady(v, n)
    return r * (b - a) / (a * b)


def by_five(r: float, s: float, n: float) -> float:
    """The integral of H between two square roots of u, with five nodes."""
    m, h = 0.5 * (r + s), 0.5 * (s - r)
    outer = rate_ratio_pair(m - B1 * h, m + B1 * h, n)
    inner = rate_ratio_pair(m - B2 * h, m + B2 * h, n)
    return (s - r) * (V0 * rate_ratio(m, n) + V1 * inner + V2 * outer)


def by_two(r: float, s: float, n: float) -> float:
    """The same with two."""
    m, h = 0.5 * (r + s), 0.5 * (s - r)
    return (s - r) * rate_ratio_pair(m - D1 * h, m + D1 * h, n)


def dtau_dxi(v: float, n: float) -> float:
    """d tau / d xi where v = 1 - u."""
    w = max(v, NEAR)
    return exact_rate(w, n) / steady(w, n)


def loading_step(y: float, xi: float, n: float) -> float:
    """y after a path of xi on the side y >= 0."""
    v, m = 1.0 - y, 1.0 + (n - 1.0) * y
    near = complement(v, m, xi, n)
    r, s = sqrt(y), sqrt(max(1.0 - near, 0.0))
    missed = by_five(r, s, n)
    tau = max(xi - missed * dtau_dxi(near, n), 0.0)
    nearer = complement(v, m, tau, n)
    missed = (xi - tau) - missed - by_two(s, sqrt(max(1.0 - nearer, 0.0)), n)
    return 1.0 - complement(v, m, max(tau + missed * dtau_dxi(nearer, n), 0.0), n)


def flow(y: float, xi: float, n: float, c: float) -> float:
    u = max(-y, 0.0)
    z = c * power(u, n)
    way = u * way_back(z, n, c)
    walked = min(xi, way)
    return loading_step(max(y, 0.0), xi - walked, n) - unloading_step(u, way, walked, n, 1.0 + z, c)


def rate(y: float, n: float, c: float) -> float:
    return 1.0 + (c if y < 0.0 else -1.0) * power(abs(y), n)


def flow_by_y(end: float, y: float, xi: float, n: float, c: float) -> float:
    start = rate(y, n, c)
    return exp(-n * xi) if start < NEAR * NEAR else rate(end, n, c) / start


WRITTEN: tuple[Callable[..., float], ...] = (
    power,
    pair,
    way_back,
    unloading_step,
    complement,
    steady,
    exact_rate,
    rate_ratio_pair,
    rate_ratio,
    by_five,
    by_two,
    dtau_dxi,
    loading_step,
    flow,
    rate,
    flow_by_y,
)


def source() -> str:
    """The text of the functions here, those of `dampyr.models.numerics.bouc_wen_exact` under their names there."""
    return "\n\n".join(read(function, function.__name__).source for function in WRITTEN)


def is_vectorisable(dampers: Iterable[tuple[Composition, Array]]) -> bool:
    """Whether the lanes can walk the Bouc-Wen states of these dampers together, and there are any."""
    spans = [span for composition, values in dampers for span in _spans(composition, values)]
    return bool(spans) and all(low <= value <= high for value, (low, high) in spans)


def _spans(composition: Composition, values: Array) -> Iterator[tuple[float, tuple[float, float]]]:
    """Each parameter of a damper's shape and where it may be."""
    parameters = dict(zip(composition.parameters, values, strict=True))
    for name in composition.names:
        if name in CALLERS:
            yield from ((parameters[f"{name}.{key}"], span) for key, span in USUAL.get(name, NOWHERE).items())
