"""Many motions, scales and inputs, and how likely a limit is exceeded, as ``dampyr ensemble`` does."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.console.building_schemas import EnsembleAsked
from dampyr.console.jobs import PAGE
from dampyr.console.safe_paths import data_of
from dampyr.report.ensemble_page import summary_rows, trust, write_ensemble_page
from dampyr.report.fragility_section import COLUMNS, fragility_rows, fragility_units, limit_in_words, remarks
from dampyr.structures import ensemble_cases, fragility
from dampyr.structures.ensemble import run as run_cases
from dampyr.to_json import plain

BAND = 0.9


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is an `EnsembleAsked`."""
    parsed = EnsembleAsked(**request)
    dataset = _dataset(parsed, data_of(folder), progress)
    progress("fragility", 0.97)
    curves = fragility(dataset, quantity=parsed.quantity, limit=parsed.limit, seed=parsed.seed)
    write_ensemble_page(dataset, folder / PAGE, [curves])
    columns, units, rows = summary_rows(dataset)
    summary = {
        "cases": dataset.attrs["cases"],
        "limit": limit_in_words(curves),
        "motions": curves.motions,
        "peaks": {"columns": columns, "units": units, "rows": rows},
        "table": {"columns": list(COLUMNS), "units": fragility_units(curves), "rows": fragility_rows(curves)},
        "remarks": remarks(curves),
        "trust": list(trust(dataset)),
        "curves": [_curve(one) for one in curves.curves],
    }
    return dict(plain(summary))


def _dataset(request: EnsembleAsked, data: Path, progress: Callable[[str, float], None]) -> Any:
    damper = request.damper.damper(data)
    inputs, word = request.damper.all_inputs(damper), request.damper.word(damper)
    count = request.motions if request.motion.kind == "kanai_tajimi" else 1
    motions = [request.motion.motion(data, seed=(request.seed, k)) for k in range(1, count + 1)]
    cases = ensemble_cases(
        request.building.building(),
        motions,
        [None, {request.damper.storey: damper}],
        inputs if word == "voltage" else None,
        request.scales,
        currents=inputs if word == "current" else None,
        allow_extrapolation=request.damper.allow_extrapolation,
    )
    workers = max(1, (os.cpu_count() or 2) - 1)
    with ThreadPoolExecutor(workers) as pool:
        return run_cases(cases, pool, None, lambda done, size: progress(f"{done} of {size} cases", 0.95 * done / size))


def _curve(one: Any) -> dict[str, Any]:
    """A curve over the peak ground acceleration, m/s2, with its band and what was counted."""
    x = np.linspace(0.0, float(one.levels.max()), 121)[1:]
    at, share, _ = one.shares()
    low, high = one.band(x, BAND) if one.exists else (None, None)
    return {
        "name": one.name,
        "x": x,
        "y": one.at(x) if one.exists else None,
        "low": low,
        "high": high,
        "counted": {"x": at, "y": share},
    }
