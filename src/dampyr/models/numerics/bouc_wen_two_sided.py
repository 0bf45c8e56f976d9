r"""The Bouc-Wen state along a monotone path with a coefficient of its own on each side of 0, exact for any exponent.

With s the direction of motion, y = s w and the path in units of 1/rho, the equation of `hardening_bouc_wen` and
`asymmetric_bouc_wen` is

.. math:: \frac{dy}{d\xi} = 1 + b_\text{out}\,y^n \ (y \ge 0), \qquad 1 + b_\text{back}\,|y|^n \ (y < 0).

Both sides have the phase :math:`\theta(u; b) = \int_0^u dv/(1 + b v^n)`, whose series are those of
`dampyr.models.numerics.bouc_wen_exact`, and a step of any length is a step of the phase. For b > 0 the phase is concave and
Newton's method from below goes up to its root without passing it. There, with n > 1, the phase has the limit
:math:`\frac{\pi/n}{\sin(\pi/n)} b^{-1/n}`: on a longer path the state is infinite, and stays so. For b < 0 the rate is 0 at
:math:`(-b)^{-1/n}`: on the way out the state approaches that, and falls back to it from beyond by its equation linearised
there; on the way back it stays there, and from beyond it never comes back.
"""

from math import exp, log

from dampyr.models.codegen.formula import intrinsic
from dampyr.models.numerics.bouc_wen_exact import (
    MAX_STEPS,
    NEAR_ZERO,
    ROUNDING,
    TERMS,
    TOO_FAR,
    phase,
    phase_back,
    state_at,
)
from dampyr.models.numerics.bouc_wen_taylor import short_enough, short_step

FAR = 1e30  # a state that is on its way to infinity, in a number that single precision holds
AT_LIMIT = 1e-13  # of the rate: the state is at its limit but for rounding
STEP = 1e-5  # of n, for central differences of the phase


def two_sided_rate(y: float, n: float, out: float, back: float) -> float:
    """dy/dxi."""
    if y < 0.0:
        return 1.0 + back * (-y) ** n
    return 1.0 + out * y**n


def rate_limit(n: float, b: float) -> float:
    """Where the rate is 0, for b < 0."""
    return exp(-log(-b) / n)


def infinite(u: float) -> float:
    """Infinity with the sign of u, which is at least `FAR`, written so that every language of the exports has it."""
    for _ in range(12):
        u = u * FAR
    return u


def place_at(theta: float, n: float, b: float, below: float) -> float:
    """The u at which theta(u; b) = theta, or infinity; for b >= 0 by Newton's method from ``below``, which is at most u."""
    if b < 0.0:
        stretch = exp(log(-b) / n)
        return state_at(stretch * theta, n) / stretch
    u = max(below, theta)
    for _ in range(TERMS):
        left = theta - phase_back(u, n, b)
        if abs(left) < short_enough(u, n, 1.0, b):
            near = short_step(u, left, n, 1.0, b)
            if near > 0.0:
                return near
        if left >= 1e-15 * theta:  # it comes from below; a motion that is not a number any more ends here too
            u = u + left * (1.0 + b * u**n)
        else:
            return u
        if u > FAR:
            return infinite(u)
    return u


def phase_by_b(u: float, n: float, b: float) -> float:
    """The derivative of theta(u; b) by b, for u > 0: integrated by parts, or by its series where that would cancel."""
    z = b * u**n
    if abs(z) > 0.25:
        return (u / (1.0 + z) - phase_back(u, n, b)) / (n * b)
    total = 0.0
    power = -(u**n)
    for k in range(1, TERMS):
        total = total + k * power / (1.0 + k * n)
        power = -z * power
        if abs(power) * k <= ROUNDING * u**n:
            break
    return u * total


def phase_by_n(u: float, n: float, b: float) -> float:
    """The derivative of theta(u; b) by n, for u > 0: by the series, or by central differences where it is slow."""
    z = b * u**n
    ell = log(u)
    if abs(z) <= 0.5:
        total = 0.0
        power = -z
        for k in range(1, TERMS):
            each = 1.0 / (1.0 + k * n)
            total = total + power * k * each * (ell - each)
            power = -z * power
            if abs(power) * k <= ROUNDING * abs(z):
                break
        return u * total
    if b > 0.0:
        return (phase_back(u, n + STEP, b) - phase_back(u, n - STEP, b)) / (2.0 * STEP)
    stretch = exp(log(-b) / n)
    y = stretch * u
    held = (phase(y, n + STEP) - phase(y, n - STEP)) / (2.0 * STEP * stretch)
    return held - log(-b) / (n * n) * (u / (1.0 + z) - phase(y, n) / stretch)


def is_beyond(end: float, y: float, n: float, out: float, back: float) -> float:
    """1 where no derivative is to be had: the state is infinite, or is held where the way back ends."""
    if abs(end) >= FAR:
        return 1.0
    if y < 0.0 and two_sided_rate(y, n, out, back) < AT_LIMIT:
        return 1.0
    return 0.0


def two_sided_by_y(end: float, y: float, xi: float, n: float, out: float, back: float) -> float:
    """The derivative of `two_sided_flow`: the ratio of the rates at the two ends; likewise the next four."""
    if is_beyond(end, y, n, out, back) > 0.0:
        return 0.0
    start = two_sided_rate(y, n, out, back)
    if start < AT_LIMIT:
        return exp(-n * xi / rate_limit(n, out))
    return two_sided_rate(end, n, out, back) / start


def two_sided_by_xi(end: float, y: float, xi: float, n: float, out: float, back: float) -> float:
    if is_beyond(end, y, n, out, back) > 0.0:
        return 0.0
    if y > 0.0 and two_sided_rate(y, n, out, back) < AT_LIMIT:
        top = rate_limit(n, out)
        return -(y - top) * n / top * exp(-n * xi / top)
    return two_sided_rate(end, n, out, back)


def two_sided_by_n(end: float, y: float, xi: float, n: float, out: float, back: float) -> float:
    if is_beyond(end, y, n, out, back) > 0.0:
        return 0.0
    speed = two_sided_rate(end, n, out, back)
    if end > 0.0 and speed < AT_LIMIT:
        top = rate_limit(n, out)
        more = log(-out) / n
        left = exp(-n * xi / top)
        return top * more / n * (1.0 - left) - max(y - top, 0.0) * left * xi * (1.0 - more) / top
    total = 0.0
    if y < 0.0:
        total = -phase_by_n(-y, n, back)
    if y > 0.0:
        total = phase_by_n(y, n, out)
    if end < 0.0:
        total = total + phase_by_n(-end, n, back)
    if end > 0.0:
        total = total - phase_by_n(end, n, out)
    return speed * total


def two_sided_by_out(end: float, y: float, xi: float, n: float, out: float, back: float) -> float:
    if is_beyond(end, y, n, out, back) > 0.0 or end <= 0.0:
        return 0.0
    speed = two_sided_rate(end, n, out, back)
    if speed < AT_LIMIT:
        top = rate_limit(n, out)
        left = exp(-n * xi / top)
        return -top / (n * out) * (1.0 - left) - max(y - top, 0.0) * left * xi / (top * out)
    total = -phase_by_b(end, n, out)
    if y > 0.0:
        total = total + phase_by_b(y, n, out)
    return speed * total


def two_sided_by_back(end: float, y: float, xi: float, n: float, out: float, back: float) -> float:
    if is_beyond(end, y, n, out, back) > 0.0 or y >= 0.0:
        return 0.0
    total = -phase_by_b(-y, n, back)
    if end < 0.0:
        total = total + phase_by_b(-end, n, back)
    return two_sided_rate(end, n, out, back) * total


def way_to_zero(y: float, xi: float, n: float, back: float) -> float:
    """The state from y < 0 after a path that does not reach 0: in a few short steps where they suffice, else by the phases."""
    left = xi
    for _ in range(MAX_STEPS):
        if left <= 0.0 or y > -NEAR_ZERO:
            break
        step = min(left, short_enough(-y, n, -1.0, -back))
        if left > TOO_FAR * step:
            break
        u = short_step(-y, step, n, -1.0, -back)
        if u <= 0.0:
            break
        y = -u
        left = left - step
    if left <= 0.0:
        return y
    return -place_at(max(phase_back(-y, n, back) - left, 0.0), n, back, 0.0)


def way_out(y: float, xi: float, n: float, out: float) -> float:
    """The state from y >= 0, likewise."""
    if y > 0.0 and two_sided_rate(y, n, out, 0.0) < AT_LIMIT:
        top = rate_limit(n, out)
        return top + (y - top) * exp(-n * xi / top)
    left = xi
    for _ in range(MAX_STEPS):
        if left <= 0.0 or y < NEAR_ZERO:
            break
        step = min(left, short_enough(y, n, 1.0, out))
        if left > TOO_FAR * step:
            break
        u = short_step(y, step, n, 1.0, out)
        if u <= 0.0:
            break
        y = u
        left = left - step
    if left <= 0.0:
        return y
    if y > 0.0:
        left = left + phase_back(y, n, out)
    return place_at(left, n, out, y)


@intrinsic(two_sided_by_y, two_sided_by_xi, two_sided_by_n, two_sided_by_out, two_sided_by_back)
def two_sided_flow(y: float, xi: float, n: float, out: float, back: float) -> float:
    """y after a path of xi >= 0, for n >= 1."""
    if abs(y) >= FAR:
        return infinite(y)
    if y >= 0.0:
        return way_out(y, xi, n, out)
    rate = two_sided_rate(y, n, out, back)
    if rate < -1e-9:
        return infinite(-FAR)
    if rate < AT_LIMIT:
        return y
    rest = phase_back(-y, n, back)
    if xi < rest:
        return way_to_zero(y, xi, n, back)
    return way_out(0.0, xi - rest, n, out)
