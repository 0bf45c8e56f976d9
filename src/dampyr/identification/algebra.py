"""The small algebra of a search in loops that numba compiles: a dozen unknowns are no work for a matrix library.

Nothing here makes an array: what is needed comes with the call. Where a matrix is near singular these functions say so, and
`dampyr.identification.normal_equations` turns to eigenvalues.
"""

from __future__ import annotations

from math import exp, inf, log, sqrt

PIVOT = 1e-6  # of Cholesky's factors of a matrix with ones on its diagonal: below it eigenvalues decide
MIN_GAP = 1e-12  # between two limits


def solved(H, g, free, scale, R, x):
    """x = H^-1 g on the free unknowns and 0 elsewhere, by Cholesky's factors; False where H is near singular."""
    n = g.size
    if not factored(H, free, scale, R):
        return False
    for i in range(n):
        x[i] = 0.0
        if free[i]:
            total = scale[i] * g[i]
            for k in range(i):
                if free[k]:
                    total -= R[i, k] * x[k]
            x[i] = total / R[i, i]
    for i in range(n - 1, -1, -1):
        if free[i]:
            total = x[i]
            for k in range(i + 1, n):
                if free[k]:
                    total -= R[k, i] * x[k]
            x[i] = total / R[i, i]
    for i in range(n):
        if free[i]:
            x[i] *= scale[i]
    return True


def factored(H, free, scale, R):
    """Cholesky's factor R of the free part of H, scaled to a diagonal of ones; False at a small pivot."""
    for i in range(scale.size):
        if not free[i]:
            continue
        if not H[i, i] > 0.0:
            return False
        scale[i] = 1.0 / sqrt(H[i, i])
        for j in range(i + 1):
            if free[j]:
                total = H[i, j] * scale[i] * scale[j]
                for k in range(j):
                    if free[k]:
                        total -= R[i, k] * R[j, k]
                if j < i:
                    R[i, j] = total / R[j, j]
                elif total > PIVOT:
                    R[i, i] = sqrt(total)
                else:
                    return False
    return True


def stepped(S, damping, low, high, chosen, H, R, work, free, s):
    """The minimum of s'Hs/2 - g's inside the box, which holds 0: an active set, one limit at a time.

    ``S`` holds H and in its last column g; each diagonal element grows by ``damping`` of it. Unknowns that are not
    ``chosen`` stay. False where H is near singular.
    """
    n = s.size
    scale, left, way = work[0], work[1], work[2]
    largest = 0.0
    for i in range(n):
        for j in range(n):
            H[i, j] = S[i, j]
        H[i, i] += damping * S[i, i]
        s[i] = 0.0
        free[i] = chosen[i] and max(high[i], 0.0) - min(low[i], 0.0) > MIN_GAP
        if chosen[i]:
            largest = max(largest, abs(S[i, n]))
    for _ in range(10 * n + 10):
        remaining(H, S, s, left)
        if not solved(H, left, free, scale, R, way):
            return False
        k = stopped(low, high, free, s, way)
        if k < 0:
            remaining(H, S, s, left)
            k = inward(low, high, chosen, free, s, left, largest)
            if k < 0:
                return True
            free[k] = True
    return True


def remaining(H, S, s, left):
    """left = g - H s."""
    n = s.size
    for i in range(n):
        left[i] = S[i, n]
        for j in range(n):
            left[i] -= H[i, j] * s[j]


def stopped(low, high, free, s, way):
    """Go along ``way`` to its end (-1), or to the first limit: which unknown stops there, no longer free."""
    reach, k = 1.0, -1
    for i in range(s.size):
        limit = min(low[i], 0.0) if way[i] < 0.0 else max(high[i], 0.0)
        if free[i] and way[i] != 0.0 and abs(limit) < inf:
            part = max((limit - s[i]) / way[i], 0.0)
            if part < reach:
                reach, k = part, i
    for i in range(s.size):
        s[i] += reach * way[i]
    if k >= 0:
        s[k] = min(low[k], 0.0) if way[k] < 0.0 else max(high[k], 0.0)
        free[k] = False
    return k


def inward(low, high, chosen, free, s, left, largest):
    """The unknown at a limit that the cost would most have leave it; -1 where there is none."""
    best, k = 1e-12 * largest, -1
    for i in range(s.size):
        if chosen[i] and not free[i] and max(high[i], 0.0) - min(low[i], 0.0) > MIN_GAP:
            slope = left[i] if s[i] <= min(low[i], 0.0) else -left[i]
            if slope > best:
                best, k = slope, i
    return k


def stepped_one(S, damping, low, high, local_low, local_high, linear, local_linear, only_linear, work, free, s):
    """As `stepped`, for one record: its nuisances are unknowns like the coefficients, and stand before them.

    ``work`` (2 n + 5, n) and ``free`` (2, n) are room.
    """
    n, L = s.size, local_low.size
    below, above, chosen = work[2 * n + 3], work[2 * n + 4], free[1]
    for i in range(n):
        nuisance = i < L
        below[i] = local_low[i] if nuisance else low[i - L]
        above[i] = local_high[i] if nuisance else high[i - L]
        chosen[i] = not only_linear or (local_linear[i] if nuisance else linear[i - L])
    return stepped(S, damping, below, above, chosen, work[:n], work[n : 2 * n], work[2 * n :], free[0], s)


def half_of_squares(sums):
    """Half the sum of squared residuals; no number where any of the sums is not finite."""
    total, seen = 0.0, 0.0
    for m in range(sums.shape[0]):
        total += sums[m, sums.shape[1] - 1, sums.shape[1] - 1]
        for i in range(sums.shape[1]):
            for j in range(sums.shape[1]):
                seen += 0.0 * sums[m, i, j]
    return 0.5 * total + seen


def gained(sums, theta, local):
    """By how much a step of (G,) coefficients and (M, L) nuisances lowers the cost, as the linear model has it."""
    L, G = local.shape[1], theta.size
    total = 0.0
    for m in range(sums.shape[0]):
        for i in range(L + G):
            d = local[m, i] if i < L else theta[i - L]
            slope = sums[m, i, L + G]
            for j in range(L + G):
                slope -= 0.5 * sums[m, i, j] * (local[m, j] if j < L else theta[j - L])
            total += d * slope
    return total


def shifted(sums, theta, local, out):
    """The sums after such a step, where the derivatives stay."""
    L, G = local.shape[1], theta.size
    last = L + G
    for m in range(sums.shape[0]):
        total = sums[m, last, last]
        for i in range(last):
            step = 0.0
            for j in range(last):
                out[m, i, j] = sums[m, i, j]
                step += sums[m, i, j] * (local[m, j] if j < L else theta[j - L])
            total += (local[m, i] if i < L else theta[i - L]) * (step - 2.0 * sums[m, i, last])
            out[m, i, last] = out[m, last, i] = sums[m, i, last] - step
        out[m, last, last] = total


def walked(sums, theta, logarithmic, low, high, below, above):
    """The sums by the logarithm of what is walked in it, in place, and how far each coefficient may step."""
    L = sums.shape[1] - theta.size - 1
    for k in range(theta.size):
        below[k], above[k] = low[k] - theta[k], high[k] - theta[k]
        if logarithmic[k]:
            below[k], above[k] = -1.0, min(1.0, log(max(high[k] / theta[k], 1.0)))
            for m in range(sums.shape[0]):
                for j in range(sums.shape[1]):
                    sums[m, L + k, j] *= theta[k]
                for j in range(sums.shape[1]):
                    sums[m, j, L + k] *= theta[k]


def moved_to(theta, step, logarithmic, low, high, out, local, local_step, local_low, local_high, local_out):
    """Coefficients and nuisances after a step, inside their limits to rounding."""
    for m in range(local.shape[0]):
        for i in range(local.shape[1]):
            local_out[m, i] = min(max(local[m, i] + local_step[m, i], local_low[i]), local_high[i])
    for k in range(theta.size):
        there = theta[k] * exp(step[k]) if logarithmic[k] else theta[k] + step[k]
        out[k] = min(max(there, low[k]), high[k])
