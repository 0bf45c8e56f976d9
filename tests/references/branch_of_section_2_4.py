"""The loading branch of the numerical example of section 2.4 of Raminelli (2020)."""

import numpy as np

from dampyr.models import Damper

KX, KW, RHO = 4.5, 6.32, 70532.0

A, F, DT = 0.008, 0.2, 1.25e-4


def branch(phase: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The loading branch, its first sample ``phase`` samples after the lower turning point; forward-difference velocity."""
    omega = 2 * np.pi * F
    t = (np.arange(60_001) + phase) * DT
    x = -A * np.cos(omega * t)
    v = (-A * np.cos(omega * (t + DT)) - x) / DT
    force = Damper("dahl", {"dahl.kx": KX, "dahl.kw": KW, "dahl.rho": RHO}).force(t, x, voltage=0.0, velocity=v)
    rising = slice(40_000, 60_000)
    return x[rising], force[rising], v[rising]
