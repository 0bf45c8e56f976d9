r"""The laws of a damper's parameters as piecewise polynomials, for kernels in which the input changes as they run.

.. math:: p(u) = \sum_j c_{kj} (u - u_k)^j, \qquad u_k \le u < u_{k+1}

Below the first knot and above the last the nearest piece goes on, as the laws themselves do.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.laws import Constant, Interpolation, Law, Polynomial

Array = NDArray[np.float64]


def pieces(law: Law) -> tuple[Array, Array]:
    """The knots (K,) where pieces begin, and their coefficients (K, degree + 1) in rising powers."""
    if isinstance(law, Constant):
        return np.zeros(1), np.array([[law.value]])
    if isinstance(law, Polynomial):
        return np.zeros(1), np.array([law.coefficients])
    if isinstance(law, Interpolation):
        return np.array(law.knots[:-1]), np.ascontiguousarray(law.pieces.T)
    raise InputError(f"a law of kind {law.kind!r} cannot follow an input that changes; take one that the card knows")


def table(damper: Any, static: bool = True) -> tuple[Array, Array]:
    """All laws of a damper: knots (P, K), infinite where a law has fewer, and coefficients (P, K, degree + 1).

    ``static=False`` sets static forces (the offset) to zero.
    """
    laws = [pieces(law) for law in damper.all_laws.values()]
    max_knots, width = max(len(knots) for knots, _ in laws), max(c.shape[1] for _, c in laws)
    knots, coefficients = np.full((len(laws), max_knots), np.inf), np.zeros((len(laws), max_knots, width))
    for k, (at, c) in enumerate(laws):
        knots[k, : len(at)], coefficients[k, : len(at), : c.shape[1]] = at, c
    if not static:
        coefficients[list(damper.composition.static)] = 0.0
    return knots, coefficients


def look_up(knots: Any, coefficients: Any, u: float, out: Any) -> None:
    """Fill ``out`` with the parameters at ``u``; plain Python for numba."""
    for k in range(knots.shape[0]):
        piece = 0
        while piece + 1 < knots.shape[1] and u >= knots[k, piece + 1]:
            piece += 1
        d, total = u - knots[k, piece], 0.0
        for j in range(coefficients.shape[2] - 1, -1, -1):
            total = total * d + coefficients[k, piece, j]
        out[k] = total
