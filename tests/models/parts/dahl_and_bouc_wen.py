"""Dampers of one part, and cycles of a cosine."""

import math

import numpy as np

from dampyr.models import Damper
from dampyr.models.parts.bouc_wen import BoucWen


def dahl(kx: float, kw: float, rho: float) -> Damper:
    return Damper("dahl", {"dahl.kx": kx, "dahl.kw": kw, "dahl.rho": rho})


def bouc_wen(model: BoucWen) -> Damper:
    return Damper("bouc_wen", {f"bouc_wen.{key}": value for key, value in vars(model).items()})


def cycle(A: float, omega: float, n: int, cycles: int = 2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = np.linspace(0.0, cycles * 2 * math.pi / omega, cycles * n + 1)
    return t, A * np.cos(omega * t), -A * omega * np.sin(omega * t)
