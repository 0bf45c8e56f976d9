r"""Random effects of groups: their mean and spread from estimates whose errors are known.

Estimates :math:`y_i` with standard errors :math:`s_i` of k groups follow :math:`y_i \sim N(\mu, \tau^2 + s_i^2)`. The spread
:math:`\tau` is that of restricted maximum likelihood; its interval is the Q-profile of Viechtbauer (2007): the values at
which :math:`Q(\tau^2) = \sum_i (y_i - \hat\mu)^2/(\tau^2 + s_i^2)` is a likely value of chi-squared with k - 1 degrees of
freedom. The interval of the mean is that of Hartung and Knapp (2001), Student's t with k - 1 and the weighted residual
variance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]
MIN_GROUPS = 3  # of two, an interval of the spread reaches thirty times its estimate
GRID = 200  # values of the spread that are tried before the best is refined
WIDEST = 1e3  # times the spread of the estimates: how far the upper end is looked for


@dataclass(frozen=True)
class RandomEffects:
    """The mean and spread of groups, in the unit of the estimates: result of `random_effects`.

    ``mean_error`` is the standard error of the mean; ``prediction`` the interval of a new group; ``shrunken`` (k,) the groups'
    values drawn towards the mean as far as their errors ask.
    """

    mean: float
    mean_error: float
    mean_interval: tuple[float, float]
    spread: float
    spread_interval: tuple[float, float]
    prediction: tuple[float, float]
    shrunken: Array


def random_effects(estimates: ArrayLike, errors: ArrayLike, level: float = 0.95) -> RandomEffects:
    """Mean, spread and intervals at ``level`` of groups with ``estimates`` (k,) and standard errors ``errors`` (k,).

    Raises InputError for fewer than three groups, or errors that are not finite and above 0.
    """
    from scipy.stats import chi2, t

    y, s = np.asarray(estimates, dtype=float), np.asarray(errors, dtype=float)
    if y.shape != s.shape or y.ndim != 1 or y.size < MIN_GROUPS:
        raise InputError(f"{y.size} estimates with {s.size} errors give no spread; give {MIN_GROUPS} or more of each")
    if not (np.all(np.isfinite(y)) and np.all(np.isfinite(s)) and np.all(s > 0)):
        raise InputError("estimates must be finite, and their errors finite and greater than 0; leave the others out")
    if not 0.0 < level < 1.0:
        raise InputError(f"level = {level:g} is not allowed; it must be between 0 and 1, such as 0.95")
    k, v = y.size, s**2
    variance = _restricted_maximum(y, v)
    weights = 1.0 / (variance + v)
    mean = float(weights @ y / weights.sum())
    error = math.sqrt(float(weights @ (y - mean) ** 2) / ((k - 1) * float(weights.sum())))
    reach = float(t.ppf(0.5 + 0.5 * level, k - 1))
    ends = [
        math.sqrt(_q_profile(y, v, float(chi2.ppf(share, k - 1)))) for share in (0.5 + 0.5 * level, 0.5 - 0.5 * level)
    ]
    beyond = reach * math.sqrt(variance + error**2)
    return RandomEffects(
        mean=mean,
        mean_error=error,
        mean_interval=(mean - reach * error, mean + reach * error),
        spread=math.sqrt(variance),
        spread_interval=(ends[0], ends[1]),
        prediction=(mean - beyond, mean + beyond),
        shrunken=mean + variance * weights * (y - mean),
    )


def _minus_log_likelihood(y: Array, v: Array, variance: float) -> float:
    """Restricted, but for a constant."""
    w = 1.0 / (variance + v)
    mean = w @ y / w.sum()
    return float(0.5 * (np.sum(np.log(variance + v)) + np.log(w.sum()) + w @ (y - mean) ** 2))


def _restricted_maximum(y: Array, v: Array) -> float:
    """The variance between groups of the highest restricted likelihood, 0 where none is higher."""
    from scipy.optimize import minimize_scalar

    top = 4.0 * float(np.ptp(y)) ** 2
    if top == 0.0:
        return 0.0
    roots = np.linspace(0.0, math.sqrt(top), GRID)
    values = [_minus_log_likelihood(y, v, root**2) for root in roots]
    best = int(np.argmin(values))
    span = roots[max(best - 1, 0)], roots[min(best + 1, GRID - 1)]
    end = minimize_scalar(lambda root: _minus_log_likelihood(y, v, root**2), bounds=span, method="bounded")
    return float(end.x) ** 2 if end.fun < _minus_log_likelihood(y, v, 0.0) else 0.0


def _q_profile(y: Array, v: Array, wanted: float) -> float:
    """The variance at which Q falls to ``wanted``; 0 where it is below that without any."""
    from scipy.optimize import brentq

    def excess(variance: float) -> float:
        w = 1.0 / (variance + v)
        return float(w @ (y - w @ y / w.sum()) ** 2) - wanted

    if excess(0.0) <= 0.0:
        return 0.0
    return float(brentq(excess, 0.0, (WIDEST * float(np.ptp(y))) ** 2, xtol=1e-14))
