r"""A short step of the Bouc-Wen state by its Taylor series, and the integrals of its derivatives by n and c.

Where a step is short against the way to the next singular point (y = 0, where the power is not smooth), a few terms of the
series meet the exact flow to rounding at a tenth of its cost. `dampyr.models.numerics.bouc_wen_exact` takes them where
the last term is small enough.

With :math:`y' = a + b\,y^n`, :math:`y = y_0(1 + \sum r_k)` and :math:`y^n = y_0^n(1 + \sum s_k)` the terms follow each other:
:math:`k\,s_k = \sum_{j=1}^{k} (j n - k + j)\, r_j s_{k-j}` (Knuth, The Art of Computer Programming 2, 4.7) and
:math:`(k+1)\, r_{k+1} = (b\,\xi\, y_0^{n-1})\, s_k`.
"""

from math import exp, log

ENOUGH = 1e-13  # of the last term; the rest of the series is a fraction of it
MAX_STEP = 0.12  # of the way to y = 0, or of the path over which the state saturates


def short_step(y: float, xi: float, n: float, a: float, b: float) -> float:
    """y after a path of xi, for 0 < y <= 1; -2 where the series does not suffice."""
    z = exp(n * log(y))
    g = xi * b * z / y
    r1 = xi * (a + b * z) / y
    s1 = n * r1
    r2 = g * s1 / 2.0
    s2 = ((n - 1.0) * r1 * s1 + 2.0 * n * r2) / 2.0
    r3 = g * s2 / 3.0
    p = (2.0 * n - 1.0) * r2 * s1
    s3 = (p + ((n - 2.0) * r1 * s2 + 3.0 * n * r3)) / 3.0
    r4 = g * s3 / 4.0
    p = (2.0 * n - 2.0) * r2 * s2 + (3.0 * n - 1.0) * r3 * s1
    s4 = (p + ((n - 3.0) * r1 * s3 + 4.0 * n * r4)) / 4.0
    r5 = g * s4 / 5.0
    p = (2.0 * n - 3.0) * r2 * s3 + (3.0 * n - 2.0) * r3 * s2 + (4.0 * n - 1.0) * r4 * s1
    s5 = (p + ((n - 4.0) * r1 * s4 + 5.0 * n * r5)) / 5.0
    r6 = g * s5 / 6.0
    p = (2.0 * n - 4.0) * r2 * s4 + (3.0 * n - 3.0) * r3 * s3 + (4.0 * n - 2.0) * r4 * s2
    q = (5.0 * n - 1.0) * r5 * s1
    s6 = (p + q + ((n - 5.0) * r1 * s5 + 6.0 * n * r6)) / 6.0
    r7 = g * s6 / 7.0
    p = (2.0 * n - 5.0) * r2 * s5 + (3.0 * n - 4.0) * r3 * s4 + (4.0 * n - 3.0) * r4 * s3
    q = (5.0 * n - 2.0) * r5 * s2 + (6.0 * n - 1.0) * r6 * s1
    s7 = (p + q + ((n - 6.0) * r1 * s6 + 7.0 * n * r7)) / 7.0
    r8 = g * s7 / 8.0
    p = (2.0 * n - 6.0) * r2 * s6 + (3.0 * n - 5.0) * r3 * s5 + (4.0 * n - 4.0) * r4 * s4
    q = (5.0 * n - 3.0) * r5 * s3 + (6.0 * n - 2.0) * r6 * s2 + (7.0 * n - 1.0) * r7 * s1
    s8 = (p + q + ((n - 7.0) * r1 * s7 + 8.0 * n * r8)) / 8.0
    r9 = g * s8 / 9.0
    p = (2.0 * n - 7.0) * r2 * s7 + (3.0 * n - 6.0) * r3 * s6 + (4.0 * n - 5.0) * r4 * s5
    q = (5.0 * n - 4.0) * r5 * s4 + (6.0 * n - 3.0) * r6 * s3 + (7.0 * n - 2.0) * r7 * s2
    o = (8.0 * n - 1.0) * r8 * s1
    s9 = (p + q + o + ((n - 8.0) * r1 * s8 + 9.0 * n * r9)) / 9.0
    r10 = g * s9 / 10.0
    if abs(r10) < ENOUGH and abs(r9) < 100.0 * ENOUGH:
        return y * (1.0 + (r10 + r9 + r8 + r7 + r6 + r5 + r4 + r3 + r2 + r1))
    return -2.0


def short_enough(y: float, n: float, a: float, b: float) -> float:
    """A path that `short_step` can take from y."""
    return MAX_STEP * y / max(abs(a + b * y**n), n)


def forward_by_n(u: float, n: float) -> float:
    """d/dn of 1/(1 - u**n)."""
    ell = log(u)
    z = exp(n * ell)
    return z * ell / ((1.0 - z) * (1.0 - z))


def backward_by_n(u: float, n: float, c: float) -> float:
    """d/dn of 1/(1 + c u**n), less its sign."""
    ell = log(u)
    z = exp(n * ell)
    return c * z * ell / ((1.0 + c * z) * (1.0 + c * z))


def backward_by_c(u: float, n: float, c: float) -> float:
    """d/dc of 1/(1 + c u**n), less its sign."""
    z = exp(n * log(u))
    return z / ((1.0 + c * z) * (1.0 + c * z))


def forward_change(low: float, high: float, n: float) -> float:
    """The integral of `forward_by_n` from low to high, by Gauss and Legendre with six nodes."""
    middle = 0.5 * (low + high)
    half = 0.5 * (high - low)
    total = 0.467913934572691 * (
        forward_by_n(middle - 0.2386191860831969 * half, n) + forward_by_n(middle + 0.2386191860831969 * half, n)
    )
    total = total + 0.3607615730481386 * (
        forward_by_n(middle - 0.6612093864662645 * half, n) + forward_by_n(middle + 0.6612093864662645 * half, n)
    )
    total = total + 0.1713244923791704 * (
        forward_by_n(middle - 0.932469514203152 * half, n) + forward_by_n(middle + 0.932469514203152 * half, n)
    )
    return half * total


def backward_change(low: float, high: float, n: float, c: float) -> float:
    """The integral of `backward_by_n` from low to high, by Gauss and Legendre with six nodes."""
    middle = 0.5 * (low + high)
    half = 0.5 * (high - low)
    total = 0.467913934572691 * (
        backward_by_n(middle - 0.2386191860831969 * half, n, c)
        + backward_by_n(middle + 0.2386191860831969 * half, n, c)
    )
    total = total + 0.3607615730481386 * (
        backward_by_n(middle - 0.6612093864662645 * half, n, c)
        + backward_by_n(middle + 0.6612093864662645 * half, n, c)
    )
    total = total + 0.1713244923791704 * (
        backward_by_n(middle - 0.932469514203152 * half, n, c) + backward_by_n(middle + 0.932469514203152 * half, n, c)
    )
    return half * total


def backward_change_by_c(low: float, high: float, n: float, c: float) -> float:
    """The integral of `backward_by_c` from low to high, by Gauss and Legendre with six nodes."""
    middle = 0.5 * (low + high)
    half = 0.5 * (high - low)
    total = 0.467913934572691 * (
        backward_by_c(middle - 0.2386191860831969 * half, n, c)
        + backward_by_c(middle + 0.2386191860831969 * half, n, c)
    )
    total = total + 0.3607615730481386 * (
        backward_by_c(middle - 0.6612093864662645 * half, n, c)
        + backward_by_c(middle + 0.6612093864662645 * half, n, c)
    )
    total = total + 0.1713244923791704 * (
        backward_by_c(middle - 0.932469514203152 * half, n, c) + backward_by_c(middle + 0.932469514203152 * half, n, c)
    )
    return half * total
