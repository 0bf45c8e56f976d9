r"""The extension of a Bouc-Wen element in series with a dashpot, over one step.

Over a step in which the ends move apart by delta (both in units of 1/rho) the element yields xi of it, and

.. math:: \xi + \beta\,(\bar y(\xi) - y) = \delta, \qquad \bar y = \tfrac16\left(y + 4\,y(\xi/2) + y(\xi)\right)

with y(xi) from `dampyr.models.numerics.bouc_wen_exact`: the mean of its force over the step, as if it were extended at a
constant rate. The left side rises by at least the change of xi, so there is one solution, between 0 and delta.
"""

from math import copysign

from dampyr.models.codegen.formula import intrinsic
from dampyr.models.numerics.bouc_wen_exact import NEAR_ZERO, flow, rate
from dampyr.models.numerics.bouc_wen_taylor import short_enough, short_step

MAX_ITERATIONS = 100  # halving the bracket alone needs about 53, the bits of a double
CLOSE = 1e-5  # of a step that converges quadratically; `advance` of `modified_bouc_wen` takes one more


def corrected(y: float, change: float, start: float, xi: float, n: float, c: float) -> float:
    """The state after a path of xi from ``start``, where y is that after one shorter by ``change``, which may be negative.

    By the series of a short step from y where it suffices: a tenth of the cost of the whole way.
    """
    side = copysign(1.0, y)
    b = c if y < 0.0 else -1.0
    if n != 1.0 and abs(y) > NEAR_ZERO and abs(change) < short_enough(abs(y), n, 1.0, b):
        near = short_step(abs(y), side * change, n, 1.0, b)
        if near > 0.0:
            return side * min(near, 1.0)
    return flow(start, xi, n, c)


@intrinsic()
def extension(y: float, delta: float, beta: float, n: float, c: float) -> float:
    """xi nearly, by Newton's method inside a bracket; y from -1 to 1, delta and beta at least 0.

    Its derivatives are not needed: the last step of Newton, taken outside, has those of the implicit function.
    """
    low = 0.0
    high = delta
    xi = delta / (1.0 + 0.5 * beta * rate(y, n, c))
    half = flow(y, 0.5 * xi, n, c)
    end = flow(half, 0.5 * xi, n, c)
    for _ in range(MAX_ITERATIONS):
        excess = xi + beta * ((y + 4.0 * half + end) / 6.0 - y) - delta
        if excess > 0.0:
            high = xi
        else:
            low = xi
        before = xi
        xi = xi - excess / slope(half, end, beta, n, c)
        if abs(xi - before) <= CLOSE * xi:
            break
        if xi < low:
            xi = 0.5 * (low + high)
        if xi > high:
            xi = 0.5 * (low + high)
        half = corrected(half, 0.5 * (xi - before), y, 0.5 * xi, n, c)
        end = corrected(end, xi - before, y, xi, n, c)
    return xi


@intrinsic()
def slope(half: float, end: float, beta: float, n: float, c: float) -> float:
    """The derivative of the left side by xi, from y half way and at the end; constant as far as derivatives go."""
    return 1.0 + beta * (2.0 * rate(half, n, c) + rate(end, n, c)) / 6.0


@intrinsic()
def held_rate(end: float, n: float, c: float) -> float:
    """dy/dxi at the end, constant likewise."""
    return rate(end, n, c)
