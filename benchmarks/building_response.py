"""The two-storey building under El Centro 1940 with the published damper, against scipy's Radau."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import el_centro
from dampyr.structures import respond, state_space, two_storey
from dampyr.studies import raminelli_2020

TITLE = "Building of chapter 5 under El Centro 1940 with the published damper: the peak of the first floor"
REFERENCES = {0.0: 27.2081e-3, 1.98: 7.4475e-3}  # V -> m; two other schemes, converged to 1e-6, printed to 4 decimals
TOLERANCES = (1e-4, 1e-6)


def run(data: Path | None) -> list[Line]:
    """dampyr at its strict accuracy, its own search for the step included, and Radau at two tolerances."""
    contenders: dict[str, Callable[[], float]] = {}
    errors = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        for volts, reference in REFERENCES.items():
            here: dict[str, Callable[[], float]] = {f"{volts:g} V: dampyr, strict": lambda volts=volts: peak(volts)}
            for rtol in TOLERANCES:
                here[f"{volts:g} V: solve_ivp Radau, rtol {rtol:g}"] = lambda volts=volts, rtol=rtol: radau(volts, rtol)
            for name, contender in here.items():
                peak_value = contender()
                errors[name] = (
                    f"{1e3 * peak_value:.5f} mm, {peak_value / reference - 1:+.0e} of {1e3 * reference:.4f} mm"
                )
            contenders |= here
        return race(contenders, errors, rounds=3)


def peak(volts: float) -> float:
    """By dampyr, in m."""
    damper = raminelli_2020.damper()
    return float(respond(two_storey(), el_centro(), {1: damper}, voltage=volts).peak_displacement[0])


def radau(volts: float, rtol: float) -> float:
    """By scipy, in m: no step longer than a sample of the ground motion, the peak read off the dense output."""
    from scipy.integrate import solve_ivp

    matrices, motion = state_space(two_storey()), el_centro()
    kx, kw, rho = raminelli_2020.damper().values(volts, static=False)
    A, B, E = matrices.A, matrices.B[:, 0], matrices.E

    def rate(time: float, y: Any) -> Any:
        z, w = y[:4], y[4]
        ground = np.interp(time, motion.time, motion.acceleration)
        force = kx * z[2] + kw * w
        return np.append(A @ z + B * force + E * ground, rho * (z[2] - abs(z[2]) * w))

    atol = np.array([1e-3, 1e-3, 1e-2, 1e-2, 1.0]) * rtol
    solution = solve_ivp(
        rate, (0.0, motion.duration), np.zeros(5), "Radau", rtol=rtol, atol=atol, max_step=motion.dt, dense_output=True
    )
    k = int(np.argmax(np.abs(solution.y[0])))
    near = np.linspace(solution.t[k - 1], solution.t[k + 1], 2001)
    return float(np.max(np.abs(solution.sol(near)[0])))
