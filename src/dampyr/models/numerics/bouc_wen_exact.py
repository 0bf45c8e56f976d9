r"""The Bouc-Wen state along a monotone path, exact for any exponent.

With s the direction of motion, y = s w and the path in units of 1/rho, the normalised Bouc-Wen equation is

.. math:: \frac{dy}{d\xi} = 1 - y^n \ (y \ge 0), \qquad 1 + c\,|y|^n \ (y < 0), \qquad c = 2\sigma - 1.

Both sides separate, so a step of any length is :math:`\theta(y_1) = \theta(y_0) + \xi` with the phases

.. math:: \theta = \int_0^y \frac{du}{1-u^n} = y\,{}_2F_1(1, b; 1+b; y^n), \qquad
          \theta_- = \int_0^u \frac{du}{1+c u^n} = u\,{}_2F_1(1, b; 1+b; -c u^n), \qquad b = 1/n.

They are summed from their series (near saturation from the one in 1 - y^n: Abramowitz and Stegun 15.3.10;
for c > 0 after Pfaff's transformation, 15.3.4; for c u^n > 2 in 1/(c u^n)) and inverted to rounding by Newton's method, whose
last step is a series of its own (`dampyr.models.numerics.bouc_wen_taylor`). For c < 0 the second is the first with u stretched
by :math:`(-c)^b`, so that it has the same two series, of which the one near saturation converges where sigma is small. n = 1
and n = 2 are elementary.
"""

from math import atan, exp, expm1, log, log1p, sqrt, tan, tanh

from dampyr.models.codegen.formula import intrinsic
from dampyr.models.numerics.bouc_wen_taylor import (
    backward_change,
    backward_change_by_c,
    forward_change,
    short_enough,
    short_step,
)

TERMS = 4000  # an upper limit only: the sums end where a term is below ROUNDING
ROUNDING = 1e-17  # a term that no longer changes a sum of order 1
SATURATED = 1e-15  # of 1 - y: a few roundings from the limit, where y stays
MAX_STEPS = 6  # short ones, which cost a tenth of the phases; the phases take what is left after them
TOO_FAR = 8.0  # times the first of them: such a step is left to the phases
NEAR_ZERO = 0.1  # closer to y = 0 the phases are quicker


def digamma_gap(b: float) -> float:
    """psi(1) - psi(b) for 0 < b: recurrence up to b + 10, then the asymptotic series."""
    gap = -0.57721566490153286
    z = b
    for _ in range(10):
        gap = gap + 1.0 / z
        z = z + 1.0
    r = 1.0 / (z * z)
    return gap - (
        log(z) - 0.5 / z - r * (1.0 / 12.0 - r * (1.0 / 120.0 - r * (1.0 / 252.0 - r * (1.0 / 240.0 - r / 132.0))))
    )


def phase_low(y: float, n: float) -> float:
    """theta(y) for 0 <= y and y**n at most about 1/2."""
    z = y**n
    total = 0.0
    power = 1.0
    for k in range(TERMS):
        term = power / (1.0 + k * n)
        total = total + term
        power = power * z
        if term < ROUNDING:
            break
    return y * total


def phase_high(y: float, ell: float, n: float) -> float:
    """theta(y) for y**n from about 1/2 up to 1, with ell = -log(1 - y**n)."""
    b = 1.0 / n
    gap = digamma_gap(b)
    e = exp(-ell)
    weight = 1.0
    total = 0.0
    for k in range(TERMS):
        term = weight * (gap + ell)
        total = total + term
        gap = gap + 1.0 / (k + 1.0) - 1.0 / (b + k)
        weight = weight * (e * (b + k) / (k + 1.0))
        if weight * (abs(gap) + ell) < ROUNDING:
            break
    return y * b * total


def phase_near(u: float, n: float, c: float) -> float:
    """theta_-(u) for 0 <= u <= 1, c > -1 and c u**n at most about 2."""
    z = c * u**n
    if c >= 0.0:
        b = 1.0 / n
        q = z / (1.0 + z)
        total = 0.0
        term = 1.0
        for k in range(TERMS):
            total = total + term
            term = term * (q * (k + 1.0) / (1.0 + b + k))
            if term < ROUNDING:
                break
        return u * total / (1.0 + z)
    stretch = (-c) ** (1.0 / n)
    if z > -0.5:
        return phase_low(stretch * u, n) / stretch
    return phase_high(stretch * u, -log(1.0 + z), n) / stretch


def phase_far(u: float, n: float, c: float) -> float:
    """theta_-(u) for c u**n > 2: up to 2 as before, then the series in 1/(c u**n) term by term."""
    low = (2.0 / c) ** (1.0 / n)
    ratio = log(u / low)
    m = 1.0 - n
    first = ratio
    if abs(m) > 1e-12:
        first = expm1(m * ratio) / m
    total = phase_near(low, n, c) + 0.5 * low * first
    shrink = 1.0 / (c * u**n)
    sign = -1.0
    at_low = 0.5 * low
    at_u = u * shrink
    for k in range(1, TERMS):
        at_low = 0.5 * at_low
        at_u = at_u * shrink
        total = total + sign * (at_u - at_low) / (1.0 - (k + 1.0) * n)
        sign = -sign
        if at_low < ROUNDING * low:
            break
    return total


def phase_back(u: float, n: float, c: float) -> float:
    """theta_-(u) for 0 <= u <= 1 and c > -1."""
    if c * u**n > 2.0:
        return phase_far(u, n, c)
    return phase_near(u, n, c)


def phase(y: float, n: float) -> float:
    """theta(y) for 0 <= y < 1."""
    z = y**n
    if z < 0.5:
        return phase_low(y, n)
    return phase_high(y, -log(1.0 - z), n)


def state_at(theta: float, n: float) -> float:
    """The y at which theta(y) = theta >= 0: Newton's method, and its end by the series of a short step."""
    half = 0.5 ** (1.0 / n)
    if theta < phase_low(half, n):
        y = min(theta, half)
        for _ in range(60):
            left = theta - phase_low(y, n)
            if abs(left) < short_enough(y, n, 1.0, -1.0):
                near = short_step(y, left, n, 1.0, -1.0)
                if near > 0.0:
                    return near
            y = y + left * (1.0 - y**n)
            if abs(left) < 1e-16:
                break
        return y
    ell = max(n * theta - digamma_gap(1.0 / n), 0.5)
    for _ in range(60):
        if ell > 40.0:
            return 1.0
        y = (1.0 - exp(-ell)) ** (1.0 / n)
        left = theta - phase_high(y, ell, n)
        if abs(left) < short_enough(y, n, 1.0, -1.0):
            near = short_step(y, left, n, 1.0, -1.0)
            if near > 0.0:
                return min(near, 1.0)
        step = left * n * y ** (n - 1.0)
        ell = max(ell + step, 0.3)
        if abs(step) < 1e-13:
            break
    return (1.0 - exp(-ell)) ** (1.0 / n)


def back_at(theta: float, n: float, c: float, guess: float) -> float:
    """The u at which theta_-(u) = theta, likewise from a ``guess`` between 0 and 1."""
    u = guess
    for _ in range(60):
        left = theta - phase_back(u, n, c)
        if abs(left) < short_enough(u, n, 1.0, c):
            near = short_step(u, left, n, 1.0, c)
            if near > 0.0:
                return min(near, 1.0)
        step = left * (1.0 + c * u**n)
        u = min(max(u + step, 0.0), 1.0)
        if abs(step) < 1e-16:
            break
    return u


def way_back(u: float, part: float, way: float, n: float, c: float) -> float:
    """A guess of what is left of u after a ``part`` of the ``way`` to 0: the cubic with its rates at both ends."""
    more = 1.0 - part
    guess = more * more * (u * (1.0 + 2.0 * part) - (1.0 + c * u**n) * way * part) + way * part * part * more
    return min(max(guess, 0.0), u)


def flow_one(y: float, xi: float, c: float) -> float:
    """The step for n = 1."""
    if y < 0.0:
        if abs(c) < 1e-12:
            rest = -y
        else:
            rest = log1p(-c * y) / c
        if xi < rest:
            if abs(c) < 1e-12:
                return y + xi
            return y - (1.0 - c * y) * expm1(-c * xi) / c
        return 1.0 - exp(-(xi - rest))
    return 1.0 + (y - 1.0) * exp(-xi)


def flow_two(y: float, xi: float, c: float) -> float:
    """The step for n = 2 and c >= 0."""
    if y < 0.0:
        if c < 1e-12:
            rest = -y
        else:
            rest = atan(-y * sqrt(c)) / sqrt(c)
        if xi < rest:
            if c < 1e-12:
                return y + xi
            return -tan((rest - xi) * sqrt(c)) / sqrt(c)
        return tanh(xi - rest)
    e = tanh(xi)
    return (y + e) / (1.0 + y * e)


def flow_any(y: float, xi: float, n: float, c: float) -> float:
    """The step for any n: in a few short ones where their series suffice, and the rest by the phases."""
    left = xi
    for _ in range(MAX_STEPS):
        if left <= 0.0 or y > -NEAR_ZERO:
            break
        h = min(left, short_enough(-y, n, -1.0, -c))
        if left > TOO_FAR * h:
            break
        u = short_step(-y, h, n, -1.0, -c)
        if u <= 0.0:
            break
        y = -u
        left = left - h
    if left > 0.0 and y < 0.0:
        rest = phase_back(-y, n, c)
        if left < rest:
            return -back_at(rest - left, n, c, way_back(-y, left / rest, rest, n, c))
        return state_at(left - rest, n)
    for _ in range(MAX_STEPS):
        if left <= 0.0 or y < NEAR_ZERO or 1.0 - y < SATURATED:
            break
        h = min(left, short_enough(y, n, 1.0, -1.0))
        if left > TOO_FAR * h:
            break
        u = short_step(y, h, n, 1.0, -1.0)
        if u <= 0.0:
            break
        y = min(u, 1.0)
        left = left - h
    if left <= 0.0 or 1.0 - y < SATURATED:
        return y
    return state_at(phase(y, n) + left, n)


def rate(y: float, n: float, c: float) -> float:
    """dy/dxi."""
    if y < 0.0:
        return 1.0 + c * (-y) ** n
    return 1.0 - y**n


def signed_phase(y: float, n: float, c: float) -> float:
    """theta, negative on the side y < 0."""
    if y < 0.0:
        return -phase_back(-y, n, c)
    return phase(y, n)


def flow_by_y(end: float, y: float, xi: float, n: float, c: float) -> float:
    """d flow / dy: the ratio of the rates at the two ends (the fundamental solution of an autonomous equation)."""
    start = rate(y, n, c)
    if start < 1e-9:
        return exp(-n * xi)
    return rate(end, n, c) / start


def flow_by_xi(end: float, y: float, xi: float, n: float, c: float) -> float:
    """d flow / dxi: the rate at the end."""
    return rate(end, n, c)


def flow_by_n(end: float, y: float, xi: float, n: float, c: float) -> float:
    """d flow / dn = rate * (d theta/dn at the start less the end); these by quadrature where
    the step is short, else by central differences (about 1e-9)."""
    h = 1e-5
    speed = rate(end, n, c)
    if speed < 1e-13 or 1.0 - y < 1e-13:
        return 0.0
    if y > xi and n * xi < 0.7:
        return -speed * forward_change(y, end, n)
    if y < 0.0 and end < 0.5 * y:
        return speed * backward_change(-end, -y, n, c)
    more = signed_phase(y, n + h, c) - signed_phase(end, n + h, c)
    less = signed_phase(y, n - h, c) - signed_phase(end, n - h, c)
    return speed * (more - less) / (2.0 * h)


def flow_by_c(end: float, y: float, xi: float, n: float, c: float) -> float:
    """d flow / dc, likewise; only a step that starts against the motion depends on c."""
    if y >= 0.0:
        return 0.0
    if end < 0.5 * y:
        return rate(end, n, c) * backward_change_by_c(-end, -y, n, c)
    h = 1e-6 * (1.0 + c)
    change = phase_back(-y, n, c - h) - phase_back(-y, n, c + h)
    if end < 0.0:
        change = change - phase_back(-end, n, c - h) + phase_back(-end, n, c + h)
    return rate(end, n, c) * change / (2.0 * h)


@intrinsic(flow_by_y, flow_by_xi, flow_by_n, flow_by_c)
def flow(y: float, xi: float, n: float, c: float) -> float:
    """y after a path of xi >= 0, for -1 <= y <= 1, n >= 1 and c = 2 sigma - 1 > -1."""
    if n == 1.0:
        return flow_one(y, xi, c)
    if n == 2.0 and c >= 0.0:
        return flow_two(y, xi, c)
    return flow_any(y, xi, n, c)
