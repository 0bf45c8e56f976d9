r"""From the letters of the literature, in SI, to the laws of the parts.

The sources give alpha, c0 and c1 as polynomials of the input u. Those of `bouc_wen` are polynomials still, since
:math:`k_w = \alpha z_\max`. Those of `modified_bouc_wen` are ratios of two, :math:`v_c = k_w/c_1`, :math:`r = c_0/c_1`,
:math:`\kappa = k_0/k_w`; they are interpolated at knots that crowd where the denominator is small, and stay within 1e-4 of
the ratio.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dampyr.models.laws import Constant, Interpolation, Law, Polynomial
from dampyr.models.parts.bouc_wen import Printed

KNOTS = 65


def bouc_wen(
    limits: tuple[float, float],
    c0: Sequence[float],
    alpha: Sequence[float],
    A: float,
    beta: float,
    gamma: float,
    n: float,
) -> dict[str, Law | float]:
    """The laws of `bouc_wen` without its spring; ``c0`` and ``alpha`` in rising powers of the input, gamma with \\|v\\| z."""
    z_max = Printed(0.0, 0.0, 1.0, A, beta, gamma, n).z_max
    return {
        "bouc_wen.c0": Polynomial(tuple(c0), *limits),
        "bouc_wen.k0": Constant(0.0, *limits),
        "bouc_wen.kw": Polynomial(tuple(a * z_max for a in alpha), *limits),
        "bouc_wen.rho": Constant(A / z_max, *limits),
        "bouc_wen.sigma": Constant(gamma / (beta + gamma), *limits),
        "bouc_wen.n": Constant(n, *limits),
    }


def modified_bouc_wen(
    limits: tuple[float, float],
    c0: Sequence[float],
    c1: Sequence[float],
    alpha: Sequence[float],
    k0: float,
    k1: float,
    A: float,
    beta: float,
    gamma: float,
    n: float,
) -> dict[str, Law | float]:
    """The laws of `modified_bouc_wen`; ``c0``, ``c1``, ``alpha`` in rising powers of the input, gamma with \\|v\\| z."""
    z_max = Printed(0.0, k0, 1.0, A, beta, gamma, n).z_max
    kw = [a * z_max for a in alpha]
    return {
        "modified_bouc_wen.kw": Polynomial(tuple(kw), *limits),
        "modified_bouc_wen.k1": Constant(k1, *limits),
        "modified_bouc_wen.vc": ratio(kw, c1, limits),
        "modified_bouc_wen.r": ratio(c0, c1, limits),
        "modified_bouc_wen.kappa": ratio([k0], kw, limits),
        "modified_bouc_wen.rho": Constant(A / z_max, *limits),
        "modified_bouc_wen.sigma": Constant(gamma / (beta + gamma), *limits),
        "modified_bouc_wen.n": Constant(n, *limits),
    }


def ratio(above: Sequence[float], below: Sequence[float], limits: tuple[float, float]) -> Interpolation:
    """``above/below``, two polynomials in rising powers, as a law between the limits."""
    low, high = limits
    u = low + (high - low) * np.linspace(0.0, 1.0, KNOTS) ** 2
    values = np.polynomial.polynomial.polyval(u, above) / np.polynomial.polynomial.polyval(u, below)
    return Interpolation(tuple(map(float, u)), tuple(map(float, values)))
