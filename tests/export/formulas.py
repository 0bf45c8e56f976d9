"""Functions in the Python of parts, of every form that the exports write."""

import ast
import inspect
from collections.abc import Callable
from math import copysign, exp


def polynomial(x: float, y: float) -> float:
    z = x**2 - 3.0 * x * y + y**3
    return z / (2.0 + abs(y)) if (x > -1.5 and not_far(x, y) > 0.0) or y == 0.25 else -z


def not_far(x: float, y: float) -> float:
    return min(x, y) - max(-5.0, x - y)


def two_values(x: float, y: float) -> tuple[float, float]:
    a, b = x + y, x * y
    return a, copysign(exp(-abs(b)), x)


def looped(x: float, y: float) -> float:
    a, b = two_values(x, y)
    total = 0.0
    for k in range(1, 6):
        total = total + a * k
        if total > 3.0:
            total = total - b
        else:
            total = total + x**1.5 if x > 0.0 else total
        if total > 40.0:
            break
    return total


FORMULAS: tuple[Callable[..., float], ...] = (polynomial, not_far, looped)
POINTS = [(0.5, 1.25), (-2.0, 0.25), (-1.7, -0.4), (3.0, -2.0), (8.0, 2.0), (0.0, 0.0)]


def trees() -> list[ast.FunctionDef]:
    """The syntax trees of all functions, what is called before what calls it."""
    functions = (not_far, polynomial, two_values, looped)
    return [ast.parse(inspect.getsource(function)).body[0] for function in functions]  # type: ignore[misc]
