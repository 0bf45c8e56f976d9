"""The force of the Dahl model along a path of 10,000 samples, against general solvers and a plain loop."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.models import Damper

TITLE = "Dahl force along 10,000 samples (polygon through a 20 mm, 0.8 Hz sine at 100 Hz)"
N, DT = 10_000, 0.01
KX, KW, RHO = 800.0, 55.0, 25_000.0


def run(data: Path | None) -> list[Line]:
    """dampyr, a loop in plain Python, and scipy's RK45 and LSODA held to one step per sample."""
    t = np.arange(N) * DT
    x = 0.01 * np.sin(2 * np.pi * 0.8 * t)
    v = np.gradient(x, t)
    damper = Damper("dahl", {"dahl.kx": KX, "dahl.kw": KW, "dahl.rho": RHO})
    contenders = {
        "dampyr": lambda: damper.force(t, x, voltage=0.0, velocity=v),
        "plain Python loop, exact step": lambda: looped(t, x, v),
        "solve_ivp LSODA, max_step = dt": lambda: solved(t, x, v, "LSODA", max_step=DT),
        "solve_ivp RK45, max_step = dt": lambda: solved(t, x, v, "RK45", max_step=DT),
        "solve_ivp LSODA, default steps": lambda: solved(t, x, v, "LSODA"),
    }
    exact = looped(t, x, v)
    errors = {name: f"error {_error(contender(), exact):.1e} of the peak" for name, contender in contenders.items()}
    errors["plain Python loop, exact step"] = "the reference"
    return race(contenders, errors, rounds=3)


def looped(t: Any, x: Any, v: Any) -> Any:
    """w1 = s + (w0 - s) exp(-rho |dx|), one sample after another."""
    w, out = 0.0, np.empty(len(t))
    out[0] = KX * v[0]
    for i in range(1, len(t)):
        dx = x[i] - x[i - 1]
        s = math.copysign(1.0, dx)
        w = s + (w - s) * math.exp(-RHO * abs(dx))
        out[i] = KX * v[i] + KW * w
    return out


def solved(t: Any, x: Any, v: Any, method: str, **options: Any) -> Any:
    """The same path as a differential equation in time."""
    from scipy.integrate import solve_ivp

    speed = np.append(np.diff(x) / DT, 0.0).tolist()
    last = N - 2

    def rate(time: float, w: Any) -> list[float]:
        u = speed[min(max(int(time / DT), 0), last)]
        return [RHO * (u - abs(u) * w[0])]

    solution = solve_ivp(rate, (t[0], t[-1]), [0.0], method, t_eval=t, rtol=1e-6, atol=1e-8, **options)
    return KX * v + KW * solution.y[0]


def _error(force: Any, exact: Any) -> float:
    return float(np.max(np.abs(force - exact)) / np.max(np.abs(exact)))
