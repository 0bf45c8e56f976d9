r"""Velocity and displacement of an acceleration that is linear between its samples: exact integrals.

.. math:: v_{i+1} = v_i + \tfrac{h}{2}(a_i + a_{i+1}), \qquad
          d_{i+1} = d_i + h v_i + \tfrac{h^2}{6}(2 a_i + a_{i+1})

Between the samples v is a parabola and d a cubic, whose peaks have closed forms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def velocity(a: Array, h: float) -> Array:
    """The integral (n,) of ``a`` (n,), from 0."""
    return _cumulative(0.5 * h * (a[:-1] + a[1:]))


def displacement(a: Array, h: float) -> Array:
    """The double integral (n,) of ``a`` (n,), from 0 and at rest."""
    return _cumulative(h * velocity(a, h)[:-1] + h**2 / 6 * (2 * a[:-1] + a[1:]))


def peak_velocity(a: Array, h: float) -> float:
    """The largest size of the velocity, between samples too: at the zeros of the acceleration."""
    v = velocity(a, h)
    turn = np.flatnonzero(a[:-1] * a[1:] < 0)
    inside = v[turn] + 0.5 * h * a[turn] ** 2 / (a[turn] - a[turn + 1])
    return float(max(np.abs(v).max(), np.abs(inside).max(initial=0.0)))


def peak_displacement(a: Array, h: float) -> float:
    """The largest size of the displacement, between samples too: at the zeros of the velocity."""
    v, d = velocity(a, h)[:-1], displacement(a, h)
    slope = (a[1:] - a[:-1]) / h
    peak = float(np.abs(d).max())
    for t in _roots(0.5 * slope, a[:-1], v):
        inside = (t > 0) & (t < h)
        t = np.where(inside, t, 0.0)
        at = d[:-1] + t * (v + t * (a[:-1] / 2 + t * slope / 6))
        peak = max(peak, float(np.abs(at).max()))
    return peak


def _cumulative(steps: Array) -> Array:
    return np.concatenate(([0.0], np.cumsum(steps)))


def _roots(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """Both roots of a t^2 + b t + c, NaN where there is none; the form that does not cancel."""
    with np.errstate(invalid="ignore", divide="ignore"):
        q = -0.5 * (b + np.copysign(np.sqrt(b * b - 4 * a * c), b))
        return q / a, c / q
