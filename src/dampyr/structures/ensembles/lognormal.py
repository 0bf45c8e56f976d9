r"""Lognormal curves by maximum likelihood: from binary outcomes, and from capacities of which some are censored.

.. math:: P(x) = \Phi\!\left(\frac{\ln(x/\theta)}{\beta}\right) = \Phi(a + b\ln x), \qquad b = 1/\beta,\ a = -\ln(\theta)/\beta

Both log-likelihoods are concave in (a, b), so that Newton's method ends at the one maximum if there is one
([Olsen1978]_). There is none where yes and no are separated by a value of x: the curve would be a step at an
undetermined place.

References
----------
.. [Baker2015] J. W. Baker, "Efficient analytical fragility function fitting using dynamic structural analysis", Earthquake
   Spectra 31(1), 579-599, 2015, eqs. 3 and 7 to 11.
.. [Shinozuka2000] M. Shinozuka, M. Q. Feng, J. Lee and T. Naganuma, "Statistical analysis of fragility curves", Journal of
   Engineering Mechanics 126(12), 1224-1231, 2000.
.. [Olsen1978] R. J. Olsen, "Note on the uniqueness of the maximum likelihood estimator for the tobit model", Econometrica
   46(5), 1211-1215, 1978.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MAX_ITERATIONS = 60  # far more than Newton's method needs on a concave function
TOLERANCE = 1e-10  # of the Newton decrement, in units of log-likelihood
Parts = tuple[Array, Array, Array]  # log-likelihood of each point, its slope and its curvature by z


@dataclass(frozen=True)
class Lognormal:
    """``theta``, the median, in the unit of x, and ``beta``, the standard deviation of its logarithm; NaN with a ``reason``."""

    theta: float
    beta: float
    reason: str = ""

    @property
    def exists(self) -> bool:
        """Whether there is a curve."""
        return not self.reason


def no_curve(reason: str) -> Lognormal:
    """No curve, and why."""
    return Lognormal(math.nan, math.nan, reason)


def fit_binomial(x: Array, yes: Array, cases: Array) -> Lognormal:
    """The curve through ``yes`` of ``cases`` at each intensity ``x`` (points,), binomial likelihood [Baker2015]_, eq. 11."""
    no = cases - yes
    if not yes.sum() > 0:
        return no_curve("no case exceeds the limit; raise the scales or lower the limit")
    if not no.sum() > 0:
        return no_curve("every case exceeds the limit; lower the scales or raise the limit")
    if x[yes > 0].min() >= x[no > 0].max():
        return no_curve(
            f"the cases below {x[yes > 0].min():.4g} all hold and those above all exceed: the spread cannot be told from them"
        )
    if x[yes > 0].max() <= x[no > 0].min():
        return no_curve("stronger motions exceed the limit less: this is not a fragility over this intensity")
    y = np.log(x)

    def parts(z: Array) -> Parts:
        up, down = _tail(z), _tail(-z)
        return (
            yes * up[0] + no * down[0],
            yes * up[1] - no * down[1],
            yes * up[2] + no * down[2],
        )

    return _maximise(y, parts)


def by_capacity(x: Array, kind: Array, weight: Array) -> Lognormal:
    """The curve of capacities ``x``: known (``kind`` 0), greater than x (+1), or less than x (-1); [Baker2015]_, eq. 7.

    Of largest likelihood: beta has the divisor n where no capacity is censored, not the n - 1 of eq. 3."""
    observed = kind == 0
    if weight[observed].sum() < 2 or np.ptp(np.log(x[observed & (weight > 0)])) == 0:
        return no_curve("fewer than two different capacities are known; refine or widen the scales")
    y = np.log(x)

    def parts(z: Array) -> Parts:
        above, below = _tail(-z), _tail(z)
        right = kind > 0
        value = np.select([observed, right], [-0.5 * z**2, above[0]], below[0])
        slope = np.select([observed, right], [-z, -above[1]], below[1])
        curve = np.select([observed, right], [-np.ones_like(z), above[2]], below[2])
        return weight * value, weight * slope, weight * curve

    return _maximise(y, parts, float(weight[observed].sum()))


def _tail(z: Array) -> Parts:
    r""":math:`\ln\Phi(z)`, its first and its second derivative."""
    from scipy.special import log_ndtr

    value = log_ndtr(z)
    ratio = np.exp(-0.5 * z**2 - 0.5 * math.log(2 * math.pi) - value)
    return value, ratio, -ratio * (z + ratio)


def _maximise(y: Array, parts: Callable[[Array], Parts], observed_weight: float = 0.0) -> Lognormal:
    """Maximise the sum of ``parts(a + b y)`` + ``observed_weight`` log b by Newton's method, halving steps that lead down."""
    centre, spread = float(y.mean()), float(y.std()) or 1.0
    u = (y - centre) / spread  # so that a and b are of the size of 1

    def value(p: Array) -> float:
        if observed_weight and p[1] <= 0:
            return -math.inf
        return float(parts(p[0] + p[1] * u)[0].sum()) + (observed_weight * math.log(p[1]) if observed_weight else 0.0)

    p, now = np.array([0.0, 1.0]), value(np.array([0.0, 1.0]))
    for _ in range(MAX_ITERATIONS):
        _, slope, curve = parts(p[0] + p[1] * u)
        gradient = np.array([slope.sum(), slope @ u + (observed_weight / p[1] if observed_weight else 0.0)])
        off = float(curve @ u)
        hessian = np.array(
            [[curve.sum(), off], [off, curve @ u**2 - (observed_weight / p[1] ** 2 if observed_weight else 0.0)]]
        )
        try:
            step = np.linalg.solve(-hessian, gradient)
        except np.linalg.LinAlgError:
            return no_curve("the likelihood is flat: the cases do not tell a curve")
        if not gradient @ step > TOLERANCE:
            break
        size = 1.0
        while value(p + size * step) < now and size > 1e-6:
            size /= 2
        p = p + size * step
        now = value(p)
    else:
        return no_curve(f"the likelihood has no top within {MAX_ITERATIONS} steps: the cases hardly tell a curve")
    return _curve(p, centre, spread)


def _curve(p: Array, centre: float, spread: float) -> Lognormal:
    b = float(p[1]) / spread
    if b <= 0:
        return no_curve("stronger motions exceed the limit less: this is not a fragility over this intensity")
    return Lognormal(math.exp(centre - float(p[0]) / b), 1.0 / b)
