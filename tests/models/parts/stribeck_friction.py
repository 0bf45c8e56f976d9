"""A LuGre damper in the letters of its source, and a motion of two sines."""

import numpy as np

from dampyr.models import Damper

FC, FS, SIGMA0, SIGMA1, SIGMA2, VS = 80.0, 104.0, 80.0 * 900.0, 60.0, 500.0, 0.01

E = FS / FC - 1.0


def damper(**changes: float) -> Damper:
    values = {"fc": FC, "sigma1": SIGMA1, "sigma2": SIGMA2, "rho": SIGMA0 / FC, "e": E, "vs": VS} | changes
    return Damper("lugre", {f"lugre.{key}": value for key, value in values.items()})


def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 0.004 * np.sin(7 * t) + 0.001 * np.sin(23 * t), 0.028 * np.cos(7 * t) + 0.023 * np.cos(23 * t)
