r"""exp and tanh without branches and without calls, so that a compiler takes several samples at once.

:math:`e^y = 2^k e^r` with k the integer nearest to y/ln 2 and :math:`|r| \le \tfrac12 \ln 2`, where the series up to
:math:`r^{13}` meets :math:`e^r` to rounding: the relative error is at most 4e-16, and beyond the range of doubles the value is
0 or infinity (already within 0.7 of its end in y: there are no subnormal values). With :math:`z = 2 |y|`,

.. math:: \tanh |y| = \frac{e^z - 1}{e^z + 1}, \qquad e^z - 1 = 2^k (e^r - 1) + (2^k - 1),

which keeps its relative error for small y too.

Reference: J.-M. Muller, Elementary Functions (2016), chapter 11 (range reduction after Cody and Waite).
"""

import numpy as np

PER_LN2 = 1.4426950408889634  # 1/ln 2
LN2_HIGH = 6.93147180369123816490e-01  # ln 2 in two parts: the first has trailing zeros, so k times it is exact
LN2_LOW = 1.90821492927058770002e-10  # the rest of ln 2
TO_INTEGER = 6755399441055744.0  # 1.5 * 2**52: what is added to it is rounded to an integer
LOWEST, HIGHEST = -709.3, 709.9  # there the power of two is 0 and infinite
BIAS = 1023  # of the exponent of a double
SATURATED = 40.0  # twice the y beyond which tanh is 1 to rounding


def less_one(r: float) -> float:
    """e**r - 1 for abs(r) up to ln(2)/2."""
    q = 1.6059043836821613e-10 * r + 2.08767569878681e-09
    q = q * r + 2.505210838544172e-08
    q = q * r + 2.755731922398589e-07
    q = q * r + 2.7557319223985893e-06
    q = q * r + 2.48015873015873e-05
    q = q * r + 1.984126984126984e-04
    q = q * r + 1.3888888888888889e-03
    q = q * r + 8.333333333333333e-03
    q = q * r + 4.1666666666666664e-02
    q = q * r + 1.6666666666666666e-01
    q = q * r + 0.5
    return q * r * r + r


def two_to(k: float) -> float:
    """2**k of an integer from -1023 (where it is 0) to 1024 (where it is infinite)."""
    return np.int64((np.int64(k) + BIAS) << 52).view(np.float64)


def quick_exp(y: float) -> float:
    """e**y."""
    y = LOWEST if y < LOWEST else y
    y = HIGHEST if y > HIGHEST else y
    k = (y * PER_LN2 + TO_INTEGER) - TO_INTEGER
    return (1.0 + less_one((y - k * LN2_HIGH) - k * LN2_LOW)) * two_to(k)


def quick_tanh(y: float) -> float:
    """tanh(y)."""
    z = 2.0 * abs(y)
    z = SATURATED if z > SATURATED else z
    k = (z * PER_LN2 + TO_INTEGER) - TO_INTEGER
    power = two_to(k)
    gone = power * less_one((z - k * LN2_HIGH) - k * LN2_LOW) + (power - 1.0)
    return np.copysign(gone / (gone + 2.0), y)
