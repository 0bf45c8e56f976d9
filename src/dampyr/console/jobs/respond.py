"""A building with and without a damper in an earthquake, as ``dampyr simulate`` does."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.console import curves
from dampyr.console.building_schemas import ResponseAsked
from dampyr.console.jobs import CURVES, PAGE
from dampyr.console.safe_paths import data_of
from dampyr.report.response_page import write_response_page
from dampyr.structures import Response, respond
from dampyr.to_json import plain

BARE = "no damper"
FRAMES = 900
POINTS = 1200


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is a `ResponseAsked`."""
    parsed = ResponseAsked(**request)
    data = data_of(folder)
    building, motion, damper = parsed.building.building(), parsed.motion.motion(data), parsed.damper.damper(data)
    inputs = parsed.damper.all_inputs(damper)
    progress("without damper", 0.0)
    cases = {BARE: respond(building, motion)}
    for k, u in enumerate(inputs, start=1):
        progress(f"case {k + 1} of {len(inputs) + 1}", k / (len(inputs) + 1))
        given: dict[str, Any] = {
            parsed.damper.word(damper): u,
            "allow_extrapolation": parsed.damper.allow_extrapolation,
        }
        response = respond(building, motion, {parsed.damper.storey: damper}, **given)
        cases[response.laws[0] or f"{u:g} {damper.input}"] = response
    progress("writing the page", 0.95)
    write_response_page(cases, folder / PAGE)
    write_whole(folder / CURVES, json.dumps(_curves(cases)))
    return {
        "title": f"{building.name}, {motion.name}",
        "floors": list(cases[BARE].floors),
        "unit": damper.input,
        "cases": [_summarise(name, each) for name, each in cases.items()],
    }


def _summarise(name: str, r: Response) -> dict[str, Any]:
    """Peaks and energies of a case, SI."""
    e = r.energy
    ends = {
        "input": e.input,
        "viscous": e.viscous,
        "dampers": e.damper,
        "moving": e.kinetic + e.strain,
        "residual": e.residual,
    }
    summary = {
        "name": name,
        "peak_displacement": r.peak_displacement,
        "peak_drift": r.peak_drift,
        "peak_acceleration": r.peak_acceleration,
        "peak_base_shear": r.peak_base_shear,
        "peak_force": r.peak_force,
        "mean_input": r.input.mean(axis=1),
        "energy": {word: float(values[-1]) for word, values in ends.items()},
        "scheme": r.scheme,
        "step": r.step,
        "converged": r.converged,
        "reason": r.reason,
        "outside": list(r.outside),
    }
    return dict(plain(summary))


def _curves(cases: dict[str, Response]) -> dict[str, Any]:
    first = cases[BARE]
    stride = max(1, len(first.time) // FRAMES)
    return {
        "ground": _line(first.time, first.ground_acceleration),
        "frames": {
            "time": np.round(first.time[::stride], 4).tolist(),
            "ground": [0.0] * len(first.time[::stride]),
            "cases": {name: np.round(r.displacement[:, ::stride], 7).tolist() for name, r in cases.items()},
        },
        "cases": {name: _case(r) for name, r in cases.items()},
    }


def _case(r: Response) -> dict[str, Any]:
    e = r.energy
    parts = {"input": e.input, "viscous": e.viscous, "dampers": e.damper, "moving": e.kinetic + e.strain}
    return {
        "displacement": [_line(r.time, row) for row in r.displacement],
        "drift": [_line(r.time, row) for row in r.drift],
        "acceleration": [_line(r.time, row) for row in r.acceleration],
        "loops": [_line(x, f, 2 * POINTS) for x, f in zip(r.stroke, r.force, strict=True)],
        "inputs": [_line(r.time, row) for row in r.input],
        "energy": {word: _line(r.time, values) for word, values in parts.items()},
    }


def _line(x: Any, y: Any, points: int = POINTS) -> dict[str, Any]:
    return curves.line(x, y, points).model_dump()
