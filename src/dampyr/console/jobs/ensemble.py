"""An ensemble and its fragility curves, as ``dampyr ensemble`` makes them."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.console.building_schemas import EnsembleRequest, files_read
from dampyr.console.dampers import damper_of
from dampyr.console.equivalent_commands import ensemble_command
from dampyr.console.jobs import DATA, PAGE
from dampyr.console.page_tables import page_table
from dampyr.console.safe_paths import data_of
from dampyr.show.figures.fragility import axis_of
from dampyr.show.figures.symbols import with_law_words
from dampyr.show.pages.ensemble_page import FRACTIONS
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.result_page import write_page
from dampyr.show.structures.ensemble_result import peak_table, trust
from dampyr.show.structures.fragility import LEVEL, comparisons, curve_table, limit_in_words
from dampyr.structures import EnsembleResult, incremental
from dampyr.structures import ensemble as run_ensemble
from dampyr.structures.ensembles.fragility import Fragility, FragilityCurve
from dampyr.to_json import plain


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is an `EnsembleRequest`."""
    parsed, data = EnsembleRequest(**request), data_of(folder)
    damper = damper_of(data, parsed.damper.name)
    with ThreadPoolExecutor(max(1, (os.cpu_count() or 2) - 1)) as pool:  # one core is left to the console and the rig
        result = run_ensemble(
            parsed.building.building(data),
            parsed.synthetic_or_one(data),
            [None, parsed.damper.placed(damper)],
            **parsed.damper.inputs_by_kind(damper),
            scales=parsed.scales,
            executor=pool,
            options=parsed.options(),
            progress=lambda done, size: progress(f"{done} of {size} cases", 0.95 * done / size),
        )
    progress("writing the page", 0.97)
    with made_by(ensemble_command(parsed), files_read(data, parsed)):
        write_page(result, folder / PAGE)
    return {DATA: result.as_dict(), **_summarise(result)}


def _summarise(result: EnsembleResult) -> dict[str, Any]:
    """What the page shows in its own form, besides the data."""
    dataset = result.dataset
    summary = {
        "notice": result.origin.notice,
        "cases": dataset.attrs["cases"],
        "motions": dataset.sizes["motion"],
        "peaks": page_table(peak_table(dataset)),
        "trust": [*(finding.sentence for finding in result.findings), *trust(dataset)],
        "fragilities": [_fragility(curves) for curves in result.curves],
        "incremental": _incremental(result),
    }
    return dict(plain(summary))


def _incremental(result: EnsembleResult) -> dict[str, Any] | None:
    """The fractiles of the largest drift over the intensity, as the page of the command draws them; SI."""
    if result.dataset.sizes["scale"] < 2 or "drift" not in result.dataset:
        return None
    analysis = incremental(result.dataset, "drift", result.intensity, fractions=FRACTIONS)
    axis = axis_of(analysis.intensity)
    return {
        "axis": {"words": axis.words, "unit": axis.unit, "factor": axis.per_si},
        "sweeps": [
            {
                "name": with_law_words(sweep.name),
                "levels": sweep.levels,
                "fractiles": np.where(np.isfinite(sweep.fractiles), sweep.fractiles, np.nan),
                "unbounded": sweep.unbounded,
                "bent_back": sweep.bent_back,
            }
            for sweep in analysis.sweeps
        ],
    }


def _fragility(curves: Fragility) -> dict[str, Any]:
    """The curves of one limit."""
    axis = axis_of(curves.intensity)
    return {
        "limit": limit_in_words(curves),
        "axis": {"words": axis.words, "unit": axis.unit, "factor": axis.per_si},
        "table": page_table(curve_table(curves)),
        "remarks": [with_law_words(sentence) for sentence in comparisons(curves)],
        "curves": [_curve(curve) for curve in curves.curves],
    }


def _curve(curve: FragilityCurve) -> dict[str, Any]:
    """A curve over the intensity, SI, with its band and what was counted."""
    x = np.linspace(0.0, float(curve.levels.max()), 121)[1:]
    intensity, share, _ = curve.shares()
    low, high = curve.band(x, LEVEL) if curve.exists else (None, None)
    return {
        "name": with_law_words(curve.name),
        "x": x,
        "y": curve.at(x) if curve.exists else None,
        "determined": not curve.no_band,
        "low": low,
        "high": high,
        "counted": {"x": intensity, "y": share},
    }
