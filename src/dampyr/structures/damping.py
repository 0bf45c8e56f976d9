r"""Damping matrices from damping ratios, for any building.

**Rayleigh**, :math:`C = \alpha M + \beta K`: the ratio of a mode is :math:`\alpha/(2\omega) + \beta\omega/2`, so two modes
can be chosen; the others follow, the ones above with more.

**Modal**, :math:`C = M \Phi\, \mathrm{diag}(2 \zeta_i \omega_i)\, \Phi^T M` with mass-normalised modes: a ratio for every
mode, and a full matrix.

Reference: Chopra (2012), Dynamics of Structures, 4th ed., sections 11.4.1 and 11.4.3.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]


def rayleigh(
    M: ArrayLike, K: ArrayLike, damping_ratio: float | Sequence[float], modes: tuple[int, int] = (1, 2)
) -> Array:
    """C (n, n) [N s/m] that gives two modes their damping ratios.

    Parameters
    ----------
    M, K
        ``(n, n)`` in kg and N/m.
    damping_ratio
        Of critical, from 0 to below 1: one for both modes, or a pair. A building of one degree of freedom has one mode and
        takes one ratio.
    modes
        The two modes, counted from 1 by rising frequency.

    Raises
    ------
    InputError
        A ratio or a mode is not allowed, or some mode would have a negative ratio, which would feed it.
    """
    square, _ = _modes(M, K)
    ratios = _ratios(damping_ratio, min(len(square), 2), "one, or one for each of the two modes")
    (first, second), omega = _pair(modes, len(square)), np.sqrt(square)
    alpha, beta = _factors(omega[first], omega[second], ratios)
    _refuse_feeding(alpha, beta, omega, modes)
    return alpha * np.asarray(M, dtype=float) + beta * np.asarray(K, dtype=float)


def modal(M: ArrayLike, K: ArrayLike, damping_ratio: float | Sequence[float]) -> Array:
    """C (n, n) [N s/m] that gives every mode, by rising frequency, its ratio: one for all, or n of them."""
    square, modes = _modes(M, K)
    ratios = _ratios(damping_ratio, len(square), "one, or one per mode")
    shapes = np.asarray(M, dtype=float) @ modes
    c = shapes @ np.diag(2 * ratios * np.sqrt(square)) @ shapes.T
    return 0.5 * (c + c.T)  # a building refuses a C that rounding made unsymmetric


def _modes(M: ArrayLike, K: ArrayLike) -> tuple[Array, Array]:
    from scipy.linalg import eigh

    square, modes = eigh(np.asarray(K, dtype=float), np.asarray(M, dtype=float))
    return np.maximum(square, 0.0), modes  # a mode without stiffness comes out a rounding below 0


def _ratios(values: float | Sequence[float], count: int, wanted: str) -> Array:
    ratios = np.atleast_1d(np.asarray(values, dtype=float))
    if ratios.shape not in ((1,), (count,)):
        raise InputError(f"{ratios.size} damping ratios are given; give {wanted} ({count} here)")
    for ratio in ratios:
        if not 0 <= ratio < 1:
            raise InputError(
                f"damping_ratio = {ratio:g} is not allowed; it must be at least 0 and below 1 (0.03 is 3 %)"
            )
    return np.broadcast_to(ratios, (count,))


def _pair(modes: tuple[int, int], count: int) -> tuple[int, int]:
    if count == 1:
        return 0, 0
    chosen = [int(m) - 1 for m in modes]
    if len(chosen) != 2 or chosen[0] == chosen[1] or not all(0 <= m < count for m in chosen):
        raise InputError(f"modes = {tuple(modes)} is not allowed; give two different modes from 1 to {count}")
    return chosen[0], chosen[1]


def _factors(a: float, b: float, ratios: Array) -> tuple[float, float]:
    """alpha and beta, from the frequencies [rad/s] of the two modes and their ratios."""
    if ratios[0] == ratios[-1]:
        return float(2 * ratios[0] * a * b / (a + b)), float(2 * ratios[0] / (a + b))
    if a == b:
        raise InputError(
            "the two modes have one frequency and cannot have two ratios; choose other modes, or method='modal'"
        )
    gap = b**2 - a**2
    alpha = 2 * a * b * (ratios[0] * b - ratios[1] * a) / gap
    return float(alpha), float(2 * (ratios[1] * b - ratios[0] * a) / gap)


def _refuse_feeding(alpha: float, beta: float, omega: Array, modes: tuple[int, int]) -> None:
    scaled_ratios = 0.5 * (alpha + beta * omega**2)  # the ratio times the frequency, which may be 0
    worst = int(np.argmin(scaled_ratios))
    if scaled_ratios[worst] < -1e-12 * np.max(np.abs(scaled_ratios)):
        raise InputError(
            f"these ratios of modes {modes[0]} and {modes[1]} give mode {worst + 1} the ratio "
            f"{scaled_ratios[worst] / omega[worst]:.3g}, which feeds it; choose ratios closer together, "
            "or method='modal'"
        )
