r"""Random effects of groups: their mean and spread from estimates whose errors are known.

Estimates :math:`y_i` with standard errors :math:`s_i` of k groups follow :math:`y_i \sim N(\mu, \tau^2 + s_i^2)`. The spread
:math:`\tau` is that of restricted maximum likelihood; its interval is the Q-profile of Viechtbauer (2007): the values at
which :math:`Q(\tau^2) = \sum_i (y_i - \hat\mu)^2/(\tau^2 + s_i^2)` is a likely value of chi-squared with k - 1 degrees of
freedom. The interval of the mean is that of Hartung and Knapp (2001), Student's t with k - 1 and the weighted residual
variance, never less than 1: else it could be narrower than the groups' own errors allow (Röver, Knapp and Friede 2015).

The interval of a *new group* does not take :math:`\hat\tau` for the truth, which is 0 or small by chance where errors are as
large as the spread. Q is chi-squared whatever the spread is, so that :math:`1 - F_{\chi^2_{k-1}}(Q(\tau^2))` is a
distribution function of :math:`\tau^2` (a confidence distribution, as in Nagashima et al. 2019), with a part of it at 0.
Given the spread, the mean has the weights :math:`1/(\tau^2 + s_i^2)`, and a new group is

.. math:: y_\text{new} \mid \tau \sim N\Big(\hat\mu(\tau),\; \tau^2 + 1/\sum_i (\tau^2 + s_i^2)^{-1}\Big)

of which the quantiles are taken over the distribution of :math:`\tau`. Without errors this is Student's t with k - 1,
:math:`\bar y \pm t\, S\sqrt{1 + 1/k}`, exactly. Of 95 % intervals of new groups, 93 to 97 % held them with 3 to 12 groups
whose errors are as large as the spread, 94 to 96 % with errors of a fifth of it, and 96 to 99 % with errors of 2.5 times it
(`tests/identification/parameter_uncertainty/test_random_effects.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.models.prediction_error import check_level

Array = NDArray[np.float64]
MIN_GROUPS = 3  # of two, an interval of the spread reaches thirty times its estimate
GRID = 200  # values of the spread that are tried before the best is refined
WIDEST = 1e3  # times the spread of the estimates: how far the upper end is looked for
STEPS = 1000  # of the spread, in which its distribution is summed: 2 % each


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
    check_level(level)
    k, v = y.size, s**2
    variance = _maximise_likelihood(y, v)
    weights = 1.0 / (variance + v)
    mean = float(weights @ y / weights.sum())
    error = math.sqrt(max(float(weights @ (y - mean) ** 2) / (k - 1), 1.0) / float(weights.sum()))
    reach = float(t.ppf(0.5 + 0.5 * level, k - 1))
    ends = [
        math.sqrt(_invert_q(y, v, float(chi2.ppf(share, k - 1)))) for share in (0.5 + 0.5 * level, 0.5 - 0.5 * level)
    ]
    return RandomEffects(
        mean=mean,
        mean_error=error,
        mean_interval=(mean - reach * error, mean + reach * error),
        spread=math.sqrt(variance),
        spread_interval=(ends[0], ends[1]),
        prediction=_predict_new_group(y, v, level),
        shrunken=mean + variance * weights * (y - mean),
    )


def _minus_log_likelihood(y: Array, v: Array, variances: Array) -> Array:
    """Restricted, but for a constant, at each of the variances."""
    total = variances[:, None] + v
    square = np.sum((y - _weigh_means(y, v, variances)[:, None]) ** 2 / total, axis=1)
    return np.asarray(0.5 * (np.sum(np.log(total), axis=1) + np.log(np.sum(1.0 / total, axis=1)) + square))


def _maximise_likelihood(y: Array, v: Array) -> float:
    """The variance between groups of the highest restricted likelihood, 0 where none is higher."""
    from scipy.optimize import minimize_scalar

    top = 4.0 * float(np.ptp(y)) ** 2
    if top == 0.0:
        return 0.0

    def evaluate(root: float) -> float:
        return float(_minus_log_likelihood(y, v, np.array([root**2]))[0])

    roots = np.linspace(0.0, math.sqrt(top), GRID)
    best = int(np.argmin(_minus_log_likelihood(y, v, roots**2)))
    span = roots[max(best - 1, 0)], roots[min(best + 1, GRID - 1)]
    end = minimize_scalar(evaluate, bounds=span, method="bounded")
    return float(end.x) ** 2 if end.fun < evaluate(0.0) else 0.0


def _invert_q(y: Array, v: Array, wanted: float) -> float:
    """The variance at which Q falls to ``wanted``; 0 where it is below that without any."""
    from scipy.optimize import brentq

    def excess(variance: float) -> float:
        w = 1.0 / (variance + v)
        return float(w @ (y - w @ y / w.sum()) ** 2) - wanted

    if excess(0.0) <= 0.0:
        return 0.0
    return float(brentq(excess, 0.0, (WIDEST * float(np.ptp(y))) ** 2, xtol=1e-14))


def _predict_new_group(y: Array, v: Array, level: float) -> tuple[float, float]:
    """The interval of a new group over the confidence distribution of the spread."""
    from scipy.optimize import brentq
    from scipy.stats import chi2, norm

    size = float(np.ptp(y))
    ends = np.append(
        0.0, np.geomspace(1e-4 * (size + math.sqrt(v.min())), WIDEST * (size + math.sqrt(v.max())), STEPS) ** 2
    )
    q = np.sum((y - _weigh_means(y, v, ends)[:, None]) ** 2 / (ends[:, None] + v), axis=1)
    below = chi2.sf(q, y.size - 1)  # the distribution function of the variance; its first value is what lies at 0
    variance = np.append(0.0, np.sqrt(ends[1:] * np.append(0.25 * ends[1], ends[1:-1])))
    share = np.diff(np.append(0.0, below)) / below[-1]
    middle, spread = (
        _weigh_means(y, v, variance),
        np.sqrt(variance + 1.0 / np.sum(1.0 / (variance[:, None] + v), axis=1)),
    )

    def locate_end(wanted: float) -> float:
        reach = np.array([-1.0, 1.0]) * 1.01 * float(norm.ppf(0.5 + 0.5 * level)) * spread[:, None] + middle[:, None]
        return float(brentq(lambda x: share @ norm.cdf((x - middle) / spread) - wanted, reach.min(), reach.max()))

    return locate_end(0.5 - 0.5 * level), locate_end(0.5 + 0.5 * level)


def _weigh_means(y: Array, v: Array, variances: Array) -> Array:
    """The weighted mean at each variance between groups."""
    weights = 1.0 / (variances[:, None] + v)
    return np.asarray(weights @ y / weights.sum(axis=1))
