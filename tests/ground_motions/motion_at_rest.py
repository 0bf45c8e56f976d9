"""A motion in closed form that begins and ends at rest."""

import numpy as np

from dampyr.ground_motions import GroundMotion

N, DT = 4001, 0.01
TIME = np.arange(N) * DT


def at_rest() -> GroundMotion:
    """A motion whose velocity and displacement are known and end at 0: d = t^3 (T - t)^3 sin(2 pi t), in double precision."""
    T = TIME[-1]
    x = np.polynomial.Polynomial([0, 0, 0, T**3, -3 * T**2, 3 * T, -1]) * T**-6.0
    w = 2 * np.pi
    s, c = np.sin(w * TIME), np.cos(w * TIME)
    return GroundMotion(x.deriv(2)(TIME) * s + 2 * w * x.deriv()(TIME) * c - w**2 * x(TIME) * s, DT, source="made")
