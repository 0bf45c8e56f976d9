"""The two-storey building under El Centro 1940 with the published damper, against scipy's Radau."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.ground_motions import el_centro
from dampyr.structures import respond, state_space, two_storey
from dampyr.studies import raminelli_2020

TITLE = "Building of chapter 5 under El Centro 1940, published damper at 0 V (reference peak 27.2081 mm, known to 2e-6)"
REFERENCE = 27.2081e-3
TOLERANCES = (1e-4, 1e-6)
FINE = 20  # looks into each sample of Radau's dense output, for the peak


def run(data: Path | None) -> list[Line]:
    """dampyr strict (its own search for the step included) and fast, and Radau at two tolerances."""
    building, motion, damper = two_storey(), el_centro(), raminelli_2020.damper().without()
    contenders = {
        f"dampyr, {accuracy}": lambda accuracy=accuracy: float(
            respond(building, motion, {1: damper}, voltage=0.0, accuracy=accuracy).peak_displacement[0]
        )
        for accuracy in ("strict", "fast")
    }
    for tolerance in TOLERANCES:
        contenders[f"solve_ivp Radau, rtol {tolerance:g}"] = lambda rtol=tolerance: radau(rtol)
    errors = {name: f"error of the peak {contender() / REFERENCE - 1:+.1e}" for name, contender in contenders.items()}
    return race(contenders, errors, rounds=3)


def radau(rtol: float) -> float:
    """The peak displacement of the first floor in m."""
    from scipy.integrate import solve_ivp

    matrices, motion = state_space(two_storey()), el_centro()
    kx, kw, rho = raminelli_2020.damper().values(0.0, static=False)
    A, B, E = matrices.A, matrices.B[:, 0], matrices.E

    def rate(time: float, y: Any) -> Any:
        z, w = y[:4], y[4]
        ground = np.interp(time, motion.time, motion.acceleration)
        force = kx * z[2] + kw * w
        return np.append(A @ z + B * force + E * ground, rho * (z[2] - abs(z[2]) * w))

    atol = np.array([1e-3, 1e-3, 1e-2, 1e-2, 1.0]) * rtol
    found = solve_ivp(
        rate, (0.0, motion.duration), np.zeros(5), "Radau", rtol=rtol, atol=atol, max_step=motion.dt, dense_output=True
    )
    at = np.linspace(0.0, motion.duration, (motion.n - 1) * FINE + 1)
    return float(np.max(np.abs(found.sol(at)[0])))
