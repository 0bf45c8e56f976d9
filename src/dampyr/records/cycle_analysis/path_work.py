r"""The work of a force along a sampled path, between the samples too.

.. math:: W = \sum_k \frac{F_k + F_{k+1}}{2}\,\Delta x_k
          + \frac{\Delta F_k\,(p_{k+1} - p_k) - \Delta x_k\,(q_{k+1} - q_k)}{10} + \frac{q_{k+1}\,p_k - q_k\,p_{k+1}}{60}

It is the integral of cubic Hermite pieces of displacement and force over the number of the sample, with the slopes p and q of
[FritschButland1984]_: they keep both monotone where the samples are, and none goes across a turning point of the path, where
the force of a device has a corner. A sum of trapezoids alone is 0.5 % low at 40 samples a cycle, since it cuts off what every
loop bulges beyond its chords.

References
----------
.. [FritschButland1984] F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM
   Journal on Scientific and Statistical Computing 5(2), 1984, 300-304.
"""

from __future__ import annotations

import numpy as np

from dampyr.records.record import Array


def path_work(x: Array, force: Array) -> float:
    """The work of ``force`` (N) along ``x`` (m), ``(n,)`` each, in J: of a closed loop what is dissipated."""
    return float(np.sum(work_of_steps(x, force)))


def work_of_steps(x: Array, force: Array) -> Array:
    """The work from each sample to the next, J, ``(n - 1,)``."""
    dx, df = np.diff(x), np.diff(force)
    work: Array = 0.5 * (force[1:] + force[:-1]) * dx
    if dx.size < 2:
        return work
    turns = np.r_[True, dx[:-1] * dx[1:] < 0.0, True]  # samples that begin or end a leg
    (p0, p1), (q0, q1) = (_slopes(step, turns) for step in (dx, df))
    curved: Array = (df * (p1 - p0) - dx * (q1 - q0)) / 10.0 + (q1 * p0 - q0 * p1) / 60.0
    return work + curved


def _slopes(step: Array, turns: Array) -> tuple[Array, Array]:
    """The slopes at the beginning and at the end of each step, per sample."""
    before, after = step[:-1], step[1:]
    total = before + after
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = np.where(before * after > 0.0, 2.0 * before * after / np.where(total == 0.0, 1.0, total), 0.0)
    inner = np.r_[0.0, inner, 0.0]
    begins, ends = turns[:-1], turns[1:]
    following, preceding = np.r_[after, step[-1]], np.r_[step[0], before]
    first = np.where(ends, step, _end_slope(step, following))  # a leg of one step is a chord
    last = np.where(begins, step, _end_slope(step, preceding))
    return np.where(begins, first, inner[:-1]), np.where(ends, last, inner[1:])


def _end_slope(step: Array, neighbour: Array) -> Array:
    """The slope at the end of a leg, by a parabola through three samples, bounded so that the piece stays monotone."""
    slope = 0.5 * (3.0 * step - neighbour)
    slope = np.where(slope * step <= 0.0, 0.0, slope)
    beyond = (neighbour * step < 0.0) & (np.abs(slope) > 3.0 * np.abs(step))
    return np.where(beyond, 3.0 * step, slope)
