r"""White noise of sensors as a function of where and when it is drawn: seed, site, channel and sample.

A 64-bit number is mixed from the seed and a counter (the finaliser of splitmix64), and its two halves give two normal numbers:

.. math:: n_1 = \sqrt{-2 \ln u_1} \cos 2\pi u_2, \qquad n_2 = \sqrt{-2 \ln u_1} \sin 2\pi u_2

so nothing has to be stored, and a run at another step, on another machine or in another order has the same noise. Plain Python
for numba.

References: G. L. Steele, D. Lea and C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA (2014) 453-472;
G. E. P. Box and M. E. Muller, A note on the generation of random normal deviates, Annals of Mathematical Statistics 29 (1958)
610-611.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

MAX_SEED = 2**24 - 1  # exact as a number of single precision, too
SEED_STEP, COUNT_STEP = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xD1342543DE82EF95)
MIX_1, MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
SHIFT_30, SHIFT_27, SHIFT_31, SHIFT_32 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(32)
LOW_HALF = np.uint64(0xFFFFFFFF)
UNIT = 2.0**-32  # of one half of a number


def counter(sample: int, site: int, pair: int) -> int:
    """The number of a draw: two channels share one."""
    return sample * 65536 + site * 256 + pair


def bits(seed: Any, count: Any) -> Any:
    """64 mixed bits."""
    z = np.uint64(seed) * SEED_STEP + np.uint64(count) * COUNT_STEP
    z = (z ^ (z >> SHIFT_30)) * MIX_1
    z = (z ^ (z >> SHIFT_27)) * MIX_2
    return z ^ (z >> SHIFT_31)


def noise(seed: int, count: int) -> tuple[float, float]:
    """As `normal_pair`, for Python, where numpy would warn of whole numbers that run over."""
    with np.errstate(over="ignore"):
        return normal_pair(np.uint64(seed), np.uint64(count))


def normal_pair(seed: Any, count: Any) -> tuple[float, float]:
    """Two independent normal numbers."""
    z = bits(seed, count)
    size = math.sqrt(-2.0 * math.log((np.float64(np.int64(z >> SHIFT_32)) + 0.5) * UNIT))
    angle = 2.0 * math.pi * np.float64(np.int64(z & LOW_HALF)) * UNIT
    return size * math.cos(angle), size * math.sin(angle)
