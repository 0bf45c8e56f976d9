"""The estimate of one record's parameters, against scipy's least squares over a hand-written model in numba."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from benchmarks.bouc_wen_force import compiled
from dampyr.identification import fit
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search.problem import Problem, SearchPoint
from dampyr.identification.search.variable_projection import search
from dampyr.models import Damper
from dampyr.records import Record

TITLE = "Estimate from 10,000 samples of one record with noise (offset and initial state too), from the same start"
N, DT, NOISE = 10_000, 0.01, 2.0
TRUTH = {
    "dahl": {"kx": 800.0, "kw": 55.0, "rho": 2500.0},
    "bouc_wen": {"c0": 600.0, "k0": 900.0, "kw": 120.0, "rho": 2500.0, "sigma": 1.3, "n": 1.4},
}
START = {"rho": 1500.0, "sigma": 1.0, "n": 2.0}
SUBSTEPS = (4, 16)


def run(data: Path | None) -> list[Line]:
    """For each model: the search alone and the whole `fit` of dampyr, then the peers; the ratios are in the last column."""
    lines: list[Line] = []
    for model in TRUTH:
        record = synthetic(model)
        ours = searched(model, record)
        contenders: dict[str, Callable[[], Any]] = {f"{model}: dampyr, the search": ours}
        contenders[f"{model}: dampyr, fit with start and errors"] = lambda model=model, record=record: fit(
            record, model
        )
        for name, peer in peers(model, record).items():
            contenders[f"{model}: scipy, {name}"] = peer
        lines += compared(race(contenders, agreement(contenders, fit(record, model))), contenders)
    return lines


def synthetic(model: str) -> Record:
    """A sine of 10 mm at 0.8 Hz with white noise of 2 N."""
    t = np.arange(N) * DT
    x = 0.01 * np.sin(2 * np.pi * 0.8 * t) * np.minimum(t, 1.0)
    v = np.gradient(x, t)
    damper = Damper(model, {f"{model}.{name}": value for name, value in TRUTH[model].items()})
    noise = np.random.default_rng(0).normal(0.0, NOISE, N)
    return Record(t, x, damper.force(t, x, voltage=0.0, velocity=v) + 100.0 + noise, velocity=v, voltage=0.0)


def searched(model: str, record: Record) -> Callable[[], Any]:
    """dampyr's search from the start that the peer has too; its linear unknowns need none."""
    problem = prepared(model, [record])
    names = [c.name.partition(".")[2] for c in problem.columns]
    theta = np.array([START.get(name, 1e-9) for name in names])
    local = np.array([[float(np.mean(record.force)), 0.0]])

    def estimate() -> Any:
        return search(fresh(problem), SearchPoint(theta, local)).point.theta

    return estimate


def fresh(problem: Problem) -> Problem:
    """The problem without what an earlier search has kept."""
    return Problem(problem.composition, problem.columns, problem.pieces, problem.nuisances)


def peers(model: str, record: Record) -> dict[str, Callable[[], Any]]:
    """least_squares with its default 2-point Jacobian over a model in numba: exact steps, or classical Runge-Kutta."""
    if model == "dahl":
        return {"exact steps": lambda: dahl(record)}
    march = compiled()
    return {f"RK4 with {k} substeps": lambda k=k: bouc_wen(record, march, k) for k in SUBSTEPS}


def dahl(record: Record) -> Any:
    """kx, kw, rho by least squares."""
    march = dahl_march()

    def model(p: Any) -> Any:
        return p[0] * record.velocity + p[1] * march(record.displacement, p[2], p[4]) + p[3]

    return _least(record, model, [500.0, 100.0, START["rho"], float(np.mean(record.force)), 0.0])[:3]


def bouc_wen(record: Record, march: Callable[..., Any], substeps: int) -> Any:
    """c0, k0, kw, rho, sigma, n by least squares."""

    def model(p: Any) -> Any:
        w = march(record.displacement, p[3], p[4], p[5], substeps, p[7])
        return p[0] * record.velocity + p[1] * record.displacement + p[2] * w + p[6]

    start = [500.0, 500.0, 100.0, START["rho"], START["sigma"], START["n"], float(np.mean(record.force)), 0.0]
    return _least(record, model, start)[:6]


def _least(record: Record, model: Callable[[Any], Any], start: list[float]) -> Any:
    from scipy.optimize import least_squares

    scale = np.array([abs(s) if s else 1.0 for s in start])
    solution = least_squares(lambda z: model(z * scale) - record.force, np.array(start) / scale, xtol=1e-9, ftol=1e-9)
    return solution.x * scale


_COMPILED: dict[str, Any] = {}


def dahl_march() -> Callable[..., Any]:
    """The exact step in a loop, compiled by numba once."""
    if "dahl" not in _COMPILED:
        from numba import njit

        @njit(error_model="numpy")
        def march(x: Any, rho: float, w: float) -> Any:
            out = np.empty(x.size)
            out[0] = w
            for i in range(1, x.size):
                s = 1.0 if x[i] >= x[i - 1] else -1.0
                w = s + (w - s) * np.exp(-rho * abs(x[i] - x[i - 1]))
                out[i] = w
            return out

        _COMPILED["dahl"] = march
    return _COMPILED["dahl"]


def agreement(contenders: dict[str, Callable[[], Any]], reference: Any) -> dict[str, str]:
    """How far each contender's parameters are from those of `fit`, in its standard errors."""
    best = np.array(list(reference.parameters.values()))
    errors = np.array(list(reference.stderr.values()))
    summaries = {}
    for name, contender in contenders.items():
        result = contender()
        values = np.array(list(result.parameters.values())) if hasattr(result, "parameters") else np.asarray(result)
        apart = float(np.max(np.abs(values - best) / errors))
        summaries[name] = f"within {apart:.0e} standard errors of fit"
    return summaries


def compared(lines: list[Line], contenders: dict[str, Callable[[], Any]]) -> list[Line]:
    """The lines with each peer's time over the search and over the whole fit."""
    search_, fit_ = lines[0].median, lines[1].median
    out = lines[:2]
    for line in lines[2:]:
        ratio = f"{line.median / search_:.3g} x the search, {line.median / fit_:.3g} x fit; {line.error}"
        out.append(Line(line.name, line.median, line.fastest, line.rounds, ratio))
    return out
