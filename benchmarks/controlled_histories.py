"""Histories per second on one core under control laws: `ensemble`, a scalar loop, and a Runge-Kutta written by hand."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.errors import DampyrWarning
from dampyr.ground_motions import el_centro
from dampyr.structures import Sensor, control_law, ensemble, state_space, two_storey
from dampyr.structures.batch.assemble import KernelText
from dampyr.structures.batch.engine import Engine, control_of, launch_blocks
from dampyr.structures.batch.law_step import values_of
from dampyr.structures.batch.modal import step
from dampyr.structures.controller import design_controller
from dampyr.structures.sites import connections, make_sites
from dampyr.studies import raminelli_2020

Array = NDArray[np.float64]
TITLE = (
    "Building of chapter 5, published damper, El Centro 1940 times 0.1 to 2.08: time per history of 31.2 s on one core"
)
HIGH, PERIOD, LAG = 3.212, 0.005, 0.01  # V, s, s
QUANTITIES = ("displacement", "drift", "acceleration", "force")
SCALES = np.linspace(0.1, 2.08, 4096)
FEW = SCALES[::64]  # of peers that take their time
SENSORS = {
    "accelerations": Sensor(noise=0.05, bias=0.01, quantum=0.005, delay=1),
    "force": Sensor(noise=3.0, bias=1.0, quantum=1.0),
}
LAWS = {
    "bang-bang, ideal sensing": control_law("bang_bang", high=HIGH),
    "clipped-optimal, ideal sensing": control_law("clipped_optimal", high=HIGH),
    "LQG with Kalman filter, noise, lag": control_law("clipped_optimal_lqg", high=HIGH, lag=LAG, sensors=SENSORS),
}


def run(data: Path | None) -> list[Line]:
    """The ensemble fast and strict; one history at a time in the same steps; Runge-Kutta at half a millisecond."""
    with warnings.catch_warnings(), ThreadPoolExecutor(1) as one:
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        contenders: dict[str, tuple[Callable[[], Any], int]] = {
            "ensemble, constant 1.98 V, fast": (partial(side_by_side, one, 1.98, "fast"), len(SCALES))
        }
        for name, law in LAWS.items():
            for accuracy in ("fast", "strict"):
                contenders[f"ensemble, {name}, {accuracy}"] = partial(side_by_side, one, law, accuracy), len(SCALES)
            contenders[f"scalar loop of the same text, {name}, 2.5 ms"] = scalar(law), len(FEW)
        contenders["Runge-Kutta by hand (numba), clipped-optimal, 0.5 ms"] = partial(by_hand, 40), len(FEW)
        lines = race({name: run for name, (run, _) in contenders.items()}, {}, rounds=5, budget=40.0)
    return [per_history(line, contenders[line.name][1]) for line in lines]


def side_by_side(executor: Executor, given: Any, accuracy: str) -> Any:
    """The ensemble as its users have it."""
    return ensemble(
        two_storey(),
        el_centro(),
        raminelli_2020.damper(),
        given,
        SCALES,
        executor,
        accuracy=accuracy,
        quantities=QUANTITIES,
    )


def scalar(law: Any, m: int = 8) -> Callable[[], Any]:
    """The same text for one history at a time, m steps to a sample."""
    building, motion, damper = two_storey(), el_centro(), raminelli_2020.damper()
    [site] = make_sites(building, {1: damper}, law, None, False)
    rows = connections(building, (site,))
    control = control_of(building, rows, 0, law, damper, motion.dt, m)
    text = KernelText(
        step(building, rows, motion.dt / m), (site.composition,), QUANTITIES, block_width=1, controls=(control,)
    )
    engine = Engine(text, (site.composition,), 64, m, launch_blocks)
    values = np.tile(values_of(damper, site.values, law, control.pieces), (len(FEW), 1))
    return lambda: engine.run([motion.acceleration] * len(FEW), [values], np.zeros((len(FEW), 1)), scales=FEW)


def by_hand(m: int) -> Array:
    """Peaks (scales, 3) of first floor, second drift and force, clipped-optimal, with m steps to a sample of 20 ms."""
    building, damper, motion = two_storey(), raminelli_2020.damper(), el_centro()
    march, model = compiled(), state_space(building)
    gains = design_controller(LAWS["clipped-optimal, ideal sensing"], building, building.connection(1)[None], 0).rows[
        0, :4
    ]
    cubics = np.array([law.coefficients for law in damper.all_laws.values()])
    a, b, g = model.A[2:].copy(), float(model.B[2, 0]), float(model.E[2])
    every = round(PERIOD * m / motion.dt)
    return np.array([march(s * motion.acceleration, motion.dt, m, every, cubics, gains, HIGH, a, b, g) for s in FEW])


@lru_cache(maxsize=1)
def compiled() -> Callable[..., Any]:
    """What a user writes: the equations, the cubics of the voltage at each decision, four slopes a step."""
    from numba import njit

    @njit(fastmath=True, error_model="numpy", inline="always")
    def rates(y: Any, ground: float, kx: float, kw: float, rho: float, a: Any, b: float) -> Any:
        x1, x2, v1, v2, w = y
        force = kx * v1 + kw * w
        a1 = a[0, 0] * x1 + a[0, 1] * x2 + a[0, 2] * v1 + a[0, 3] * v2 + b * force + ground
        a2 = a[1, 0] * x1 + a[1, 1] * x2 + a[1, 2] * v1 + a[1, 3] * v2 + ground
        return v1, v2, a1, a2, rho * (v1 - abs(v1) * w)

    @njit(fastmath=True, error_model="numpy", inline="always")
    def moved(y: Any, k: Any, h: float) -> Any:
        return y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2], y[3] + h * k[3], y[4] + h * k[4]

    @njit(fastmath=True, error_model="numpy", inline="always")
    def cubic(c: Any, u: float) -> float:
        return c[0] + u * (c[1] + u * (c[2] + u * c[3]))

    @njit(fastmath=True, error_model="numpy")
    def march(
        ag: Any, dt: float, m: int, every: int, c: Any, gains: Any, high: float, a: Any, b: float, g: float
    ) -> tuple[float, float, float]:
        h = dt / m
        y = (0.0, 0.0, 0.0, 0.0, 0.0)
        floor = drift = largest = 0.0
        kx, kw, rho = cubic(c[0], 0.0), cubic(c[1], 0.0), cubic(c[2], 0.0)
        for i in range(ag.size - 1):
            slope = (ag[i + 1] - ag[i]) / m
            for j in range(m):
                if (i * m + j) % every == 0:
                    force = kx * y[2] + kw * y[4]
                    wanted = gains[0] * y[0] + gains[1] * y[1] + gains[2] * y[2] + gains[3] * y[3]
                    u = high if (wanted - force) * force > 0.0 else 0.0
                    kx, kw, rho = cubic(c[0], u), cubic(c[1], u), cubic(c[2], u)
                    largest = max(largest, abs(kx * y[2] + kw * y[4]))
                g0 = g * (ag[i] + slope * j)
                gh, g1 = g0 + 0.5 * g * slope, g0 + g * slope
                k1 = rates(y, g0, kx, kw, rho, a, b)
                k2 = rates(moved(y, k1, 0.5 * h), gh, kx, kw, rho, a, b)
                k3 = rates(moved(y, k2, 0.5 * h), gh, kx, kw, rho, a, b)
                k4 = rates(moved(y, k3, h), g1, kx, kw, rho, a, b)
                y = moved(moved(moved(moved(y, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0)
                floor, drift = max(floor, abs(y[0])), max(drift, abs(y[1] - y[0]))
                largest = max(largest, abs(kx * y[2] + kw * y[4]))
        return floor, drift, largest

    return march


def per_history(line: Line, histories: int) -> Line:
    """The line for one history."""
    median, fastest = line.median / histories, line.fastest / histories
    return replace(line, median=median, fastest=fastest, error=f"{float(f'{1 / fastest:.3g}'):,g} histories/s at best")
