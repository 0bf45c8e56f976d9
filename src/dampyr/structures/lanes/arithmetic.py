r"""What a step in lanes computes with: functions without branches, so that the compiler takes eight histories at a time.

The exponential is :math:`2^k` times a polynomial of degree 7 on :math:`|r| \le \ln 2 / 2`: 7e-9 relative in double
precision. It is held below by the smallest normal number. A hyperbolic tangent is made of it, accurate to 1e-8 absolutely.
Fits need the last digits (`dampyr.models.quick`); here the step errs far more, and every operation counts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

LANES = 64
LN2, LOG2E = math.log(2.0), 1.0 / math.log(2.0)


@lru_cache(maxsize=2)
def functions(precision: int) -> dict[str, Any]:
    """exp, tanh, copysign and eighth_over by name, for numba to inline; ``precision`` is 64 or 32 bits."""
    from numba import njit

    given = constants(precision)
    made: dict[str, Any] = {}
    for plain in (exp, copysign, tanh, eighth_over):
        made[plain.__name__] = njit(inline="always", error_model="numpy")(_copy(plain, given | made))
    return made


def _copy(function: Callable[..., Any], names: dict[str, Any]) -> Callable[..., Any]:
    from types import FunctionType

    return FunctionType(function.__code__, {**function.__globals__, **names}, function.__name__)


def constants(precision: int) -> dict[str, Any]:
    """Numbers of one precision; a literal would turn a sum of single precision into one of double."""
    kind = np.float64 if precision == 64 else np.float32
    integer = np.int64 if precision == 64 else np.int32
    digits = 52 if precision == 64 else 23
    values = {f"over_{math.factorial(k)}": 1.0 / math.factorial(k) for k in range(2, 8)}
    values |= {
        "lowest": -700.0 if precision == 64 else -87.0,
        "log2e": LOG2E,
        "ln2": LN2,
        "one": 1.0,
        "two": 2.0,
        "quarter": 0.25,
        "eighth": 0.125,
    }
    values |= {"rounding": 1.5 * 2.0**digits, "tiny": 1e-300 if precision == 64 else 1e-30}
    magic = 0x7FDE623822FC16E6 if precision == 64 else 0x7EF311C7
    return {k: kind(v) for k, v in values.items()} | {
        "digits": integer(digits),
        "magic": integer(magic),
        "sign": integer(-(2 ** (precision - 1))),
        "real": kind,
        "whole": integer,
    }


real, whole = np.float64, np.int64  # all of these are bound by `functions`
over_2 = over_6 = over_24 = over_120 = over_720 = over_5040 = 0.0
lowest = log2e = ln2 = one = two = quarter = eighth = rounding = tiny = 0.0
digits = magic = sign = 0


def exp(t: float) -> float:
    t = max(t, lowest)
    k = t * log2e + rounding
    r = t - (k - rounding) * ln2
    square = r * r
    low = (one + r) + square * (over_2 + over_6 * r)
    high = (over_24 + over_120 * r) + square * (over_720 + over_5040 * r)
    p = low + square * square * high
    return whole(real(p).view(whole) + (real(k).view(whole) << digits)).view(real)


def tanh(t: float) -> float:
    e = exp(-two * abs(t))
    return copysign((one - e) / (one + e), t)


def copysign(size: float, t: float) -> float:
    return whole(real(abs(size)).view(whole) | (real(t).view(whole) & sign)).view(real)


def eighth_over(t: float) -> float:
    """1/(8 t) of a positive number to 0.3 %, without a division."""
    y = whole(magic - real(t).view(whole)).view(real)
    return y * (quarter - eighth * t * y)
