r"""What a step in lanes computes with: functions without branches, so that the compiler takes eight histories at a time.

The exponential is :math:`2^k` times a polynomial on :math:`|r| \le \ln 2 / 2`, of degree 6 in double and 5 in single precision:
1e-8 and 5e-7 relative (and what rounding leaves), exactly 1 at 0. It is held below by the smallest normal number. A hyperbolic
tangent is made of it, accurate to 1e-8 absolutely in double precision.
The logarithm of a positive number is that of its power of 2 and a polynomial on :math:`[\sqrt{1/2}, \sqrt 2]`, 5e-9 relative.
Fits need the last digits (`dampyr.models.numerics.fast_math`); here the step errs far more, and every operation counts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from dampyr.models.codegen.kernels import named
from dampyr.structures.sensor_noise import (
    COUNT_STEP,
    LOW_HALF,
    MIX_1,
    MIX_2,
    SEED_STEP,
    SHIFT_27,
    SHIFT_30,
    SHIFT_31,
    SHIFT_32,
    UNIT,
)

BLOCK_WIDTH = 64  # of a block in double precision; one in single has twice as many, and the same bytes
LN2, LOG2E = math.log(2.0), 1.0 / math.log(2.0)
LOW, HIGH = math.sqrt(0.5) - 1.0, math.sqrt(2.0) - 1.0
SIN = (
    Chebyshev.interpolate(lambda s: np.sinc(2.0 * np.sqrt(s)) * 2.0 * math.pi, 6, domain=[0.0, 0.0625])
    .convert(kind=Polynomial)
    .coef
)  # of sin(2 pi t)/t in t squared, up to a quarter of a turn: 1e-12 of the sine
RADIUS = 0.5 * LN2 + 1e-9  # of the polynomial of the exponential
LOG = Chebyshev.interpolate(lambda t: np.log1p(t) / t, 9, domain=[LOW, HIGH]).convert(kind=Polynomial).coef


@lru_cache(maxsize=2)
def functions(precision: int) -> dict[str, Any]:
    """The functions of this module by name, for numba to inline; ``precision`` is 64 or 32 bits."""
    from numba import njit

    numbers = constants(precision)
    compiled: dict[str, Any] = {}
    for plain in (exp, log, copysign, tanh, eighth_over, rounded, sin_of_turns, normal_pair):
        compiled[plain.__name__] = njit(inline="always", error_model="numpy")(
            _copy(plain, numbers | compiled, precision)
        )
    return compiled


def _copy(function: Callable[..., Any], names: dict[str, Any], precision: int) -> Callable[..., Any]:
    copy = FunctionType(function.__code__, {**function.__globals__, **names}, function.__name__)
    return named(copy, __name__, f"{precision} bits")


def constants(precision: int) -> dict[str, Any]:
    """Numbers of one precision; a literal would turn a sum of single precision into one of double."""
    kind = np.float64 if precision == 64 else np.float32
    integer = np.int64 if precision == 64 else np.int32
    digits = 52 if precision == 64 else 23
    values = {f"log_{k}": float(a) for k, a in enumerate(LOG)}
    values |= {f"exp_{k}": a for k, a in enumerate(exp_coefficients(4 if precision == 64 else 3), start=2)}
    values |= {
        "lowest": -700.0 if precision == 64 else -87.0,
        "log2e": LOG2E,
        "ln2": LN2,
        "one": 1.0,
        "two": 2.0,
        "quarter": 0.25,
        "eighth": 0.125,
        "half": 0.5,
        "unit": UNIT,
    }
    values |= {f"sin_{k}": float(a) for k, a in enumerate(SIN)}
    values |= {"rounding": 1.5 * 2.0**digits, "tiny": 1e-300 if precision == 64 else 1e-30}
    magic = 0x7FDE623822FC16E6 if precision == 64 else 0x7EF311C7
    return {k: kind(v) for k, v in values.items()} | {
        "digits": integer(digits),
        "magic": integer(magic),
        "root_half": integer(kind(math.sqrt(0.5)).view(integer)),
        "sign": integer(-(2 ** (precision - 1))),
        "real": kind,
        "whole": integer,
    }


def exp_coefficients(degree: int) -> list[float]:
    """Of r^2 to r^6 in exp(r): ``degree`` is that of what follows 1 + r, divided by r^2."""
    t = Polynomial([1.0 / math.factorial(k + 2) for k in range(12)])
    coefficients = Chebyshev.interpolate(t, degree, domain=[-RADIUS, RADIUS]).convert(kind=Polynomial).coef
    return [*map(float, coefficients), *[0.0] * (4 - degree)]


real, whole = np.float64, np.int64  # all of these are bound by `functions`
exp_2 = exp_3 = exp_4 = exp_5 = exp_6 = 0.0  # of the series of exp
lowest = log2e = ln2 = one = two = quarter = eighth = rounding = tiny = 0.0  # numbers of the precision
log_0 = log_1 = log_2 = log_3 = log_4 = log_5 = log_6 = log_7 = log_8 = log_9 = 0.0  # of the series of log
half = unit = sin_0 = sin_1 = sin_2 = sin_3 = sin_4 = sin_5 = sin_6 = 0.0  # of normal numbers
digits = magic = sign = root_half = 0  # bits of the precision


def exp(t: float) -> float:
    t = max(t, lowest)
    k = t * log2e + rounding
    r = t - (k - rounding) * ln2
    square = r * r
    low = (one + r) + square * (exp_2 + exp_3 * r)
    high = (exp_4 + exp_5 * r) + square * exp_6
    p = low + square * square * high
    return whole(real(p).view(whole) + (real(k).view(whole) << digits)).view(real)


def log(t: float) -> float:
    bits = real(t).view(whole)
    k = whole(whole(bits - root_half) >> digits)
    r = whole(bits - whole(k << digits)).view(real) - one
    square = r * r
    fourth = square * square
    low = (log_0 + log_1 * r) + square * (log_2 + log_3 * r)
    high = (log_4 + log_5 * r) + square * (log_6 + log_7 * r)
    return real(k) * ln2 + r * (low + fourth * (high + fourth * (log_8 + log_9 * r)))


def tanh(t: float) -> float:
    e = exp(-two * abs(t))
    return copysign((one - e) / (one + e), t)


def copysign(size: float, t: float) -> float:
    return whole(real(abs(size)).view(whole) | (real(t).view(whole) & sign)).view(real)


def eighth_over(t: float) -> float:
    """1/(8 t) of a positive number to 0.3 %, without a division."""
    y = whole(magic - real(t).view(whole)).view(real)
    return y * (quarter - eighth * t * y)


def rounded(t: float) -> float:
    """The nearest whole number."""
    return (t + rounding) - rounding


def sin_of_turns(t: float) -> float:
    """The sine of t turns, for t between -1/2 and 1/2."""
    folded = copysign(quarter - abs(quarter - abs(t)), t)
    square = folded * folded
    low = (sin_0 + sin_1 * square) + square * square * (sin_2 + sin_3 * square)
    fourth = square * square
    return folded * (low + fourth * fourth * ((sin_4 + sin_5 * square) + fourth * sin_6))


def normal_pair(seed: float, count: int) -> tuple[float, float]:
    """As `dampyr.structures.sensor_noise.normal_pair`, to 1e-8; the ``seed`` is a row's number."""
    z = np.uint64(whole(seed)) * SEED_STEP + np.uint64(count) * COUNT_STEP
    z = (z ^ (z >> SHIFT_30)) * MIX_1
    z = (z ^ (z >> SHIFT_27)) * MIX_2
    z = z ^ (z >> SHIFT_31)
    size = math.sqrt(-two * log((real(np.int64(z >> SHIFT_32)) + half) * unit))
    turns = real(np.int64(z & LOW_HALF)) * unit - half  # half a turn less: both change sign
    return -size * sin_of_turns(quarter - abs(turns)), -size * sin_of_turns(turns)
