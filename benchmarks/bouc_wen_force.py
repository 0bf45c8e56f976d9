"""The force of the Bouc-Wen model along a path, against Runge-Kutta steps compiled by the same compiler."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.models import Damper

TITLE = "Bouc-Wen force along 10,000 samples, n = 1.5, sigma = 0.8 (polygon through a 20 mm, 0.8 Hz sine at 100 Hz)"
N, DT = 10_000, 0.01
RHO, SIGMA, EXPONENT, KW, C0 = 10_000.0, 0.8, 1.5, 200.0, 1500.0


def run(data: Path | None) -> list[Line]:
    """The exact step for n = 1.5 (series and Newton) and for n = 2 (elementary), and RK4 with 10, 50 and 250 substeps."""
    t = np.arange(N) * DT
    x = 0.01 * np.sin(2 * np.pi * 0.8 * t)
    v = np.gradient(x, t)
    runge_kutta = compiled()
    contenders: dict[str, Callable[[], Any]] = {"dampyr, exact": lambda: _damper(EXPONENT).force(t, x, 0.0, velocity=v)}
    for substeps in (10, 50, 250):
        contenders[f"RK4, {substeps} substeps"] = partial(stepped, runge_kutta, x, v, substeps)
    reference = stepped(runge_kutta, x, v, 2000)
    size = np.max(np.abs(reference))
    errors = {name: f"error {np.max(np.abs(c() - reference)) / size:.1e} of the peak" for name, c in contenders.items()}
    contenders["dampyr, exact, n = 2"] = lambda: _damper(2.0).force(t, x, 0.0, velocity=v)
    return race(contenders, errors)


def _damper(n: float) -> Damper:
    names = {"c0": C0, "k0": 0.0, "kw": KW, "rho": RHO, "sigma": SIGMA, "n": n}
    return Damper("bouc_wen", {f"bouc_wen.{name}": value for name, value in names.items()})


def stepped(runge_kutta: Callable[..., Any], x: Any, v: Any, substeps: int) -> Any:
    """The force by Runge-Kutta."""
    return C0 * v + KW * runge_kutta(x, RHO, SIGMA, EXPONENT, substeps)


def compiled() -> Callable[..., Any]:
    """Classical Runge-Kutta in the path, ``substeps`` to a sample, compiled by numba."""
    from numba import njit

    @njit(error_model="numpy")
    def rate(w: float, s: float, sigma: float, n: float) -> float:
        return s - sigma * abs(w) ** (n - 1.0) * w + (sigma - 1.0) * s * abs(w) ** n

    @njit(error_model="numpy")
    def march(x: Any, rho: float, sigma: float, n: float, substeps: int, w: float = 0.0) -> Any:
        out = np.zeros(x.size)
        out[0] = w
        for i in range(1, x.size):
            dx = x[i] - x[i - 1]
            s, h = (1.0 if dx >= 0.0 else -1.0), rho * abs(dx) / substeps
            for _ in range(substeps):
                k1 = rate(w, s, sigma, n)
                k2 = rate(w + 0.5 * h * k1, s, sigma, n)
                k3 = rate(w + 0.5 * h * k2, s, sigma, n)
                k4 = rate(w + h * k3, s, sigma, n)
                w += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            out[i] = w
        return out

    return march
