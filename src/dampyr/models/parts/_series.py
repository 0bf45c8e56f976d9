r"""A Bouc-Wen element in series with a dashpot: how far it is drawn in one step.

Over a step in which the ends move apart by delta (both in units of 1/rho) the element yields xi of it, and

.. math:: \xi + \beta\,(\bar y(\xi) - y) = \delta, \qquad \bar y = \tfrac16\left(y + 4\,y(\xi/2) + y(\xi)\right)

with y(xi) from `dampyr.models.flow`: the mean of its force over the step, as if it were drawn at a constant rate. The left side
rises by at least the change of xi, so there is one solution, between 0 and delta.
"""

from dampyr.models.flow import flow, flow_by_c, flow_by_n, flow_by_y, rate
from dampyr.models.formula import intrinsic

MOST_ITERATIONS = 100
CLOSE = 1e-9  # of a step that converges quadratically: the next would be below rounding


def mean_state(y: float, xi: float, n: float, c: float) -> float:
    """The mean of y along a path of xi, by Simpson's rule."""
    return (y + 4.0 * flow(y, 0.5 * xi, n, c) + flow(y, xi, n, c)) / 6.0


def mean_by_xi(y: float, xi: float, n: float, c: float) -> float:
    """Its derivative by xi."""
    return (2.0 * rate(flow(y, 0.5 * xi, n, c), n, c) + rate(flow(y, xi, n, c), n, c)) / 6.0


def steepness(xi: float, y: float, beta: float, n: float, c: float) -> float:
    """The derivative of the left side by xi."""
    return 1.0 + beta * mean_by_xi(y, xi, n, c)


def drawn_by_y(xi: float, y: float, delta: float, beta: float, n: float, c: float) -> float:
    """d drawn / dy."""
    half = flow(y, 0.5 * xi, n, c)
    end = flow(y, xi, n, c)
    mean = (1.0 + 4.0 * flow_by_y(half, y, 0.5 * xi, n, c) + flow_by_y(end, y, xi, n, c)) / 6.0
    return beta * (1.0 - mean) / steepness(xi, y, beta, n, c)


def drawn_by_delta(xi: float, y: float, delta: float, beta: float, n: float, c: float) -> float:
    """d drawn / ddelta."""
    return 1.0 / steepness(xi, y, beta, n, c)


def drawn_by_beta(xi: float, y: float, delta: float, beta: float, n: float, c: float) -> float:
    """d drawn / dbeta."""
    return (y - mean_state(y, xi, n, c)) / steepness(xi, y, beta, n, c)


def drawn_by_n(xi: float, y: float, delta: float, beta: float, n: float, c: float) -> float:
    """d drawn / dn."""
    half = flow(y, 0.5 * xi, n, c)
    end = flow(y, xi, n, c)
    mean = (4.0 * flow_by_n(half, y, 0.5 * xi, n, c) + flow_by_n(end, y, xi, n, c)) / 6.0
    return -beta * mean / steepness(xi, y, beta, n, c)


def drawn_by_c(xi: float, y: float, delta: float, beta: float, n: float, c: float) -> float:
    """d drawn / dc."""
    half = flow(y, 0.5 * xi, n, c)
    end = flow(y, xi, n, c)
    mean = (4.0 * flow_by_c(half, y, 0.5 * xi, n, c) + flow_by_c(end, y, xi, n, c)) / 6.0
    return -beta * mean / steepness(xi, y, beta, n, c)


@intrinsic(drawn_by_y, drawn_by_delta, drawn_by_beta, drawn_by_n, drawn_by_c)
def drawn(y: float, delta: float, beta: float, n: float, c: float) -> float:
    """xi, by Newton's method kept inside its bracket; y from -1 to 1, delta and beta at least 0."""
    low = 0.0
    high = delta
    xi = 0.0
    for _ in range(MOST_ITERATIONS):
        half = flow(y, 0.5 * xi, n, c)
        end = flow(y, xi, n, c)
        excess = xi + beta * ((y + 4.0 * half + end) / 6.0 - y) - delta
        if excess > 0.0:
            high = xi
        else:
            low = xi
        step = excess / (1.0 + beta * (2.0 * rate(half, n, c) + rate(end, n, c)) / 6.0)
        xi = xi - step
        if abs(step) <= CLOSE * xi:
            break
        if xi < low:
            xi = 0.5 * (low + high)
        if xi > high:
            xi = 0.5 * (low + high)
    return xi
