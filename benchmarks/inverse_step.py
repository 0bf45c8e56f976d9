"""A step of a damper and of its inverse in C, beside scipy's brentq around dampyr's force over the step."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.export import export
from dampyr.models import Damper, Polynomial
from dampyr.studies import raminelli_2020

TITLE = "The input of a wanted force: time of one step, 4,000 steps of two tones at 1 kHz"
STEPS, DT = 4000, 0.001
LOOPS = r"""
#include "damper.h"
double steps(long n, const double *x, const double *v, const double *wanted, double *u, int inverse)
{
    damper_state d; damper_inverse g; double f = 0.0;
    damper_inverse_start(&g);
    damper_start(&d, 0.0, x[0], v[0], g.low);
    for (long k = 1; k < n; k++) {
        if (inverse) u[k] = damper_inverse_find(&g, &d, 0.001, x[k], v[k], wanted[k]);
        f = damper_step_by(&d, 0.001, x[k], v[k], u[k]);
    }
    return f;
}
"""


def dampers() -> dict[str, Damper]:
    """The published cubics; straight laws, whose input has a closed form; Bouc-Wen of another exponent; a compliance."""
    kx, kw, rho = raminelli_2020.damper().laws.values()
    straight = {"kx": Polynomial((800.0, 300.0), 0, 3), "kw": Polynomial((60.0, 200.0), 0, 3), "rho": 4000.0}
    bouc_wen = {"c0": kx, "k0": 200.0, "kw": kw, "rho": rho, "sigma": 0.9, "n": 1.4}
    return {
        "Dahl, published cubics": raminelli_2020.damper(),
        "Dahl, straight laws": Damper("dahl", straight),
        "Bouc-Wen, n = 1.4": Damper("bouc_wen", bouc_wen),
        "Dahl + compliance": Damper("dahl + compliance", {"kx": kx, "kw": kw, "rho": rho, "s": 2e-6}),
    }


def run(data: Path | None) -> list[Line] | str:
    """Each damper's step forward and its step of the inverse with the step forward after it; both by dampyr and by brentq."""
    if shutil.which("gcc") is None:
        return "gcc is missing"
    t = np.arange(STEPS) * DT
    x = 0.008 * np.sin(2 * np.pi * 1.1 * t) + 0.003 * np.sin(2 * np.pi * 2.9 * t)
    v = np.gradient(x, t)
    wanted = 5000.0 * v
    contenders: dict[str, Callable[[], Any]] = {}
    errors, parts = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for k, (name, damper) in enumerate(dampers().items()):
            loop = compiled(damper, Path(folder) / str(k))
            u, fixed = np.zeros(STEPS), np.full(STEPS, 1.0)
            contenders[f"{name}: forward"] = caller(loop, x, v, wanted, fixed, 0)
            contenders[f"{name}: inverse"] = caller(loop, x, v, wanted, u, 1)
            contenders[f"{name}: inverse"]()
            found = damper.inverse().along(t, x, wanted, velocity=v)
            met = (found.reason == "met") & (t > 0.0)
            gap = np.abs(damper.force(t, x, velocity=v, voltage=u) - wanted)[met].max() / np.abs(wanted).max()
            errors[f"{name}: inverse"] = f"{np.mean(met):.0%} met, to {gap:.0e} of the largest"
        damper = raminelli_2020.damper()
        inverse = damper.inverse()
        contenders["Dahl, published cubics: Inverse.along in Python"] = lambda: inverse.along(t, x, wanted, velocity=v)
        count = STEPS // 20
        parts["brentq around Damper.force"] = STEPS / count
        contenders["brentq around Damper.force"] = lambda: by_brentq(damper, t[:count], x, v, wanted)
        lines = race(contenders, errors, rounds=3)
    per_step = {name: parts.get(name, 1.0) / STEPS for name in contenders}
    return [
        Line(each.name, factor * each.median, factor * each.fastest, each.rounds, each.error)
        for each in lines
        for factor in [per_step[each.name]]
    ]


def compiled(damper: Damper, folder: Path) -> Any:
    """The function of `LOOPS`, in a shared library."""
    export(damper, "c", folder, inverse=True)
    (folder / "loops.c").write_text(LOOPS)
    command = ["gcc", "-std=c99", "-O2", "-shared", "-fPIC", "damper.c", "loops.c", "-o", "loops.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    loop = ctypes.CDLL(str(folder / "loops.so")).steps
    array = np.ctypeslib.ndpointer(dtype=float, flags="C_CONTIGUOUS")
    loop.argtypes, loop.restype = [ctypes.c_long, array, array, array, array, ctypes.c_int], ctypes.c_double
    return loop


def caller(loop: Any, x: Any, v: Any, wanted: Any, u: Any, inverse: int) -> Callable[[], Any]:
    return lambda: loop(STEPS, x, v, wanted, u, inverse)


def by_brentq(damper: Damper, t: Any, x: Any, v: Any, wanted: Any) -> None:
    """As a script would do it: the force over each step from its state, and brentq where it changes its sign."""
    from scipy.optimize import brentq

    low, high = damper.range
    _kx, _kw, rho = damper.laws.values()
    w = 0.0
    for k in range(1, t.size):
        dt, dx = t[k - 1 : k + 1], x[k - 1 : k + 1]

        def lack(u: float, k: int = k, dt: Any = dt, dx: Any = dx, w: float = w) -> float:
            force = damper.force(dt, dx, voltage=u, velocity=v[k - 1 : k + 1], state0=[w])
            return float(force[1] - wanted[k])

        u = brentq(lack, low, high) if lack(low) * lack(high) < 0.0 else low
        s = np.sign(dx[1] - dx[0])
        w = float(np.clip(s + (w - s) * np.exp(-float(rho(u)) * abs(dx[1] - dx[0])), -1.0, 1.0))
