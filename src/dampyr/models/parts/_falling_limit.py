"""The step of `bouc_wen` from a state that may lie a little beyond its limit, because the limit has fallen."""

from math import exp

from dampyr.models.codegen.formula import intrinsic
from dampyr.models.numerics.bouc_wen_exact import flow, flow_by_c, flow_by_n, flow_by_xi, flow_by_y


def way_to_limit(y: float, c: float) -> float:
    """The path from y below -1 back to -1."""
    return (-1.0 - y) / (1.0 + c)


def falling_by_y(end: float, y: float, xi: float, n: float, c: float) -> float:
    """The derivative of `falling_flow`; likewise the next three."""
    if y > 1.0:
        return exp(-n * xi)
    if y >= -1.0:
        return flow_by_y(end, y, xi, n, c)
    rest = xi - way_to_limit(y, c)
    if rest <= 0.0:
        return 1.0
    return flow_by_xi(end, -1.0, rest, n, c) / (1.0 + c)


def falling_by_xi(end: float, y: float, xi: float, n: float, c: float) -> float:
    if y > 1.0:
        return -n * (y - 1.0) * exp(-n * xi)
    if y >= -1.0:
        return flow_by_xi(end, y, xi, n, c)
    rest = xi - way_to_limit(y, c)
    if rest <= 0.0:
        return 1.0 + c
    return flow_by_xi(end, -1.0, rest, n, c)


def falling_by_n(end: float, y: float, xi: float, n: float, c: float) -> float:
    if y > 1.0:
        return -xi * (y - 1.0) * exp(-n * xi)
    if y >= -1.0:
        return flow_by_n(end, y, xi, n, c)
    rest = xi - way_to_limit(y, c)
    if rest <= 0.0:
        return 0.0
    return flow_by_n(end, -1.0, rest, n, c)


def falling_by_c(end: float, y: float, xi: float, n: float, c: float) -> float:
    if y > 1.0:
        return 0.0
    if y >= -1.0:
        return flow_by_c(end, y, xi, n, c)
    way = way_to_limit(y, c)
    if xi <= way:
        return xi
    return flow_by_c(end, -1.0, xi - way, n, c) + flow_by_xi(end, -1.0, xi - way, n, c) * way / (1.0 + c)


@intrinsic(falling_by_y, falling_by_xi, falling_by_n, falling_by_c)
def falling_flow(y: float, xi: float, n: float, c: float) -> float:
    """`flow`, for y beyond -1 and 1 too: there by its equation linearised at the limit, right to the square of the excess."""
    if y > 1.0:
        return 1.0 + (y - 1.0) * exp(-n * xi)
    if y >= -1.0:
        return flow(y, xi, n, c)
    rest = xi - way_to_limit(y, c)
    if rest <= 0.0:
        return y + xi * (1.0 + c)
    return flow(-1.0, rest, n, c)
