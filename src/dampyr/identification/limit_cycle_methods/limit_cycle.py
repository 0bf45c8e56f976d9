r"""The limit-cycle method for the viscous Dahl model: (2.5) to (2.9) of Raminelli (2020), after Ikhouane and Rodellar (2007).

On the loading branch of a limit cycle, from the smallest displacement at 0 to the largest at T+,

.. math:: k_x = \frac{F(0) + F(T^+)}{\dot x(0) + \dot x(T^+)}, \quad \theta = F - k_x \dot x, \quad
          a = \theta'(x_*) \text{ where } \theta(x_*) = 0, \quad
          \rho = \frac{a - \theta'(x_{*1})}{\theta(x_{*1})}, \quad k_w = \frac a\rho .

For a sine both velocities in (2.5) are zero at the turning points, so kx is 0/0: it lives on the sampled velocities not being
at the turning points. Where they are, `limit_cycle` requires ``kx`` (see `plastic_region`).

The method takes one point of the loop for a and one for rho. Here the slope is that of a polynomial through the samples
around the point, so nothing depends on where a sample happens to fall; ``nearest=True`` takes the nearest sample and a
central difference instead, as published, and is uncertain by up to half a sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.shown import Shown

Array = NDArray[np.float64]
ARC = (0.2, 0.8)  # of the largest theta: clear of the zero and of saturation
ORDER = 4  # of the local polynomial: through five samples


@dataclass(frozen=True, repr=False)
class LimitCycle(Shown):
    """What the method gives, in the units of what it was given (SI: N s/m, N/m, 1/m, N, m).

    ``rho_range`` are the 5 % and 95 % quantiles of rho over every x*1 on the arc where theta is 20 to 80 % of its largest
    value: how much rho depends on that choice. ``theta`` (n,) belongs to ``x`` (n,).
    """

    kx: float
    a: float
    rho: float
    kw: float
    x_star: float
    x_star1: float
    rho_range: tuple[float, float]
    x: Array
    theta: Array


def limit_cycle(
    x: ArrayLike,
    force: ArrayLike,
    velocity: ArrayLike,
    kx: float | None = None,
    x_star1: float | None = None,
    nearest: bool = False,
    points: int = ORDER + 1,
) -> LimitCycle:
    """Identify the viscous Dahl model from the loading branch of a limit cycle.

    Parameters
    ----------
    x
        (n,) m, rising from the smallest to the largest displacement.
    force
        (n,) N, without offset.
    velocity
        (n,) m/s.
    kx
        viscous coefficient in N s/m, in the place of (2.5).
    x_star1
        m, the point that gives rho; by default that whose rho is the median of the arc.
    nearest
        take the nearest sample and a central difference, as published, and not a local polynomial.
    points
        samples of each local polynomial; more than 5 smooth noise.

    Returns
    -------
    LimitCycle
        kx, kw and rho, and how much rho depends on ``x_star1``.

    Raises
    ------
    InputError
        theta does not change sign, (2.5) is 0/0, or ``x`` does not rise.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> x = np.linspace(-0.008, 0.008, 2001)
    >>> v = 0.05 * np.sqrt(1.0 - (x / 0.0081) ** 2)
    >>> w = 1.0 - 2.0 / (1.0 + np.exp(-16.0)) * np.exp(-1000.0 * (x + 0.008))  # Dahl on a closed loop, rho = 1000 1/m
    >>> cycle = dp.identification.limit_cycle(x, 900.0 * v + 250.0 * w, v, kx=900.0)
    >>> round(cycle.kw, 1), round(cycle.rho, 1)
    (250.0, 1000.0)
    """
    branch = _check_branch(x, force, velocity)
    x, force, velocity = branch
    kx = _estimate_viscous(force, velocity) if kx is None else kx
    theta = force - kx * velocity
    zero = _locate_zero(x, theta, nearest)
    slope = _take_nearest_slope if nearest else _fit_local_slope
    a = slope(x, theta, zero, points)[1]
    arc = _select_arc(x, theta, zero)
    trials = np.array([_compute_rho(a, *slope(x, theta, at, points)) for at in x[arc]])
    if x_star1 is None:
        x_star1 = float(x[arc][int(np.argsort(trials)[trials.size // 2])])
    elif not zero < x_star1 <= x[-1]:
        raise InputError(f"x_star1 = {x_star1:g} must lie between x* = {zero:g} and the largest displacement {x[-1]:g}")
    rho = _compute_rho(a, *slope(x, theta, x_star1, points))
    span = np.quantile(trials, (0.05, 0.95))
    return LimitCycle(float(kx), a, rho, a / rho, zero, x_star1, (float(span[0]), float(span[1])), x, theta)


def _check_branch(x: ArrayLike, force: ArrayLike, velocity: ArrayLike) -> tuple[Array, Array, Array]:
    columns = [np.asarray(c, dtype=float) for c in (x, force, velocity)]
    if len({c.shape for c in columns}) > 1 or columns[0].ndim != 1 or columns[0].size < 2 * ORDER:
        shapes = ", ".join(str(c.shape) for c in columns)
        raise InputError(
            f"x, force and velocity have shapes {shapes}; give three vectors of the same length, 8 or more"
        )
    if np.any(np.diff(columns[0]) <= 0):
        k = int(np.argmax(np.diff(columns[0]) <= 0))
        raise InputError(f"x must rise along the loading branch; x[{k + 1}] = {columns[0][k + 1]:g} does not")
    return columns[0], columns[1], columns[2]


def _estimate_viscous(force: Array, velocity: Array) -> float:
    """kx by (2.5)."""
    below = velocity[0] + velocity[-1]
    if abs(below) < 1e-9 * float(np.abs(velocity).max()):
        raise InputError(
            f"(2.5) divides by the velocities at the turning points, {velocity[0]:g} and {velocity[-1]:g} m/s, which "
            "are zero; give kx (see plastic_region)"
        )
    return float((force[0] + force[-1]) / below)


def _locate_zero(x: Array, theta: Array, nearest: bool) -> float:
    """x*, where theta changes sign."""
    below = np.flatnonzero((theta[:-1] < 0.0) & (theta[1:] >= 0.0))
    if below.size == 0:
        raise InputError(
            f"theta = F - kx v runs from {theta[0]:g} to {theta[-1]:g} N and does not cross zero; remove the offset of the "
            "force, or check kx"
        )
    k = int(below[0])
    if nearest:
        return float(x[k] if -theta[k] <= theta[k + 1] else x[k + 1])
    from scipy.interpolate import BarycentricInterpolator

    first = int(np.clip(k - 1, 0, x.size - ORDER))
    around = slice(first, first + ORDER)
    if np.all(np.diff(theta[around]) > 0):  # inverse interpolation, x over theta, needs theta to rise through all four
        return float(BarycentricInterpolator(theta[around], x[around])(0.0))
    return float(np.interp(0.0, theta[k : k + 2], x[k : k + 2]))


def _take_nearest_slope(x: Array, theta: Array, at: float, points: int) -> tuple[float, float]:
    """theta and its central difference at the sample nearest to ``at``."""
    k = int(np.clip(np.argmin(np.abs(x - at)), 1, x.size - 2))
    return float(theta[k]), float((theta[k + 1] - theta[k - 1]) / (x[k + 1] - x[k - 1]))


def _fit_local_slope(x: Array, theta: Array, at: float, points: int) -> tuple[float, float]:
    """theta and its slope at ``at``, of the polynomial through (or fitted to) the samples around it."""
    k = int(np.searchsorted(x, at))
    first = int(np.clip(k - points // 2, 0, x.size - points))
    around = slice(first, first + points)
    width = 0.5 * float(np.ptp(x[around]))  # of order one: powers of millimetres in m would be ill conditioned
    polynomial = np.polynomial.Polynomial.fit(
        (x[around] - at) / width, theta[around], ORDER if points <= ORDER + 2 else 3
    ).convert()
    return float(polynomial.coef[0]), float(polynomial.coef[1] / width)


def _select_arc(x: Array, theta: Array, zero: float) -> NDArray[np.int64]:
    """The samples from which x*1 is chosen: past x*, with theta from 20 to 80 % of its largest value."""
    largest = float(theta.max())
    inside = np.flatnonzero((x > zero) & (theta > ARC[0] * largest) & (theta < ARC[1] * largest))
    if inside.size == 0:
        raise InputError(
            f"no sample has theta between {ARC[0]:.0%} and {ARC[1]:.0%} of its largest value {largest:g} N; sample faster"
        )
    stop = int(np.argmax(theta >= ARC[1] * largest)) or x.size
    selected = inside[inside < stop]
    return selected[:: max(1, selected.size // 200)] if selected.size else inside[:1]


def _compute_rho(a: float, theta: float, slope: float) -> float:
    return (a - slope) / theta
