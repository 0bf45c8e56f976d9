"""Simulation of a building with and without a damper, as ``dampyr simulate`` does it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.console import curves
from dampyr.console.building_schemas import ResponseRequest, files_read
from dampyr.console.dampers import damper_of
from dampyr.console.equivalent_commands import response_command
from dampyr.console.jobs import CURVES, DATA, PAGE
from dampyr.console.safe_paths import data_of
from dampyr.ground_motions.cutting import end_in_words
from dampyr.show.figures.symbols import with_law_words
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.result_page import write_page
from dampyr.show.structures.responses import truncation_note
from dampyr.structures import Response
from dampyr.structures import respond as respond_to
from dampyr.structures.ensembles.store import BARE
from dampyr.to_json import plain

FRAMES = 900  # of the animation: 30 a second for half a minute
POINTS = 1200  # of a line: as many as a wide screen has columns


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is a `ResponseRequest`."""
    parsed, data = ResponseRequest(**request), data_of(folder)
    damper = damper_of(data, parsed.damper.name)
    result = respond_to(
        parsed.building.building(data),
        parsed.motion.motion(data),
        parsed.damper.placed(damper),
        **parsed.damper.inputs_by_kind(damper),
        options=parsed.options(),
        progress=progress,
    )
    progress("writing the page", 0.95)
    with made_by(response_command(parsed), files_read(data, parsed)):
        write_page(result, folder / PAGE)
    shown = {with_law_words(name): response for name, response in result.cases.items()}
    write_whole(folder / CURVES, json.dumps(_curves(shown)))
    note = truncation_note(result.cases)
    return {
        DATA: result.as_dict(),
        "title": result.title,
        "notice": result.origin.notice,
        "floors": list(result.cases[BARE].floors),
        "unit": result.unit,
        "end": end_in_words(result.cases[BARE].after),
        "findings": [{"severity": finding.severity, "sentence": finding.sentence} for finding in result.findings],
        "note": f"{note}." if note else "",
        "cases": [_summarise(name, response) for name, response in shown.items()],
    }


def _summarise(name: str, r: Response) -> dict[str, Any]:
    """Peaks and energies of a case, SI."""
    ends = _energies(r) | {"residual": r.energy.residual}
    summary = {
        "name": name,
        "peak_displacement": r.peak_displacement,
        "peak_drift": r.peak_drift,
        "peak_acceleration": r.peak_acceleration,
        "peak_base_shear": r.peak_base_shear,
        "peak_force": r.peak_force,
        "mean_input": r.mean_input,
        "energy": {word: float(values[-1]) for word, values in ends.items()},
        "scheme": r.scheme,
        "step": r.step,
    }
    return dict(plain(summary))


def _curves(cases: Mapping[str, Response]) -> dict[str, Any]:
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
    return {
        "displacement": [_line(r.time, row) for row in r.displacement],
        "drift": [_line(r.time, row) for row in r.drift],
        "acceleration": [_line(r.time, row) for row in r.acceleration],
        "loops": [_line(x, f, 2 * POINTS) for x, f in zip(r.stroke, r.force, strict=True)],
        "inputs": [_line(r.time, row) for row in r.input],
        "energy": {word: _line(r.time, values) for word, values in _energies(r).items()},
    }


def _energies(r: Response) -> dict[str, Any]:
    e = r.energy
    return {"input": e.input, "viscous": e.viscous, "dampers": e.damper, "moving": e.kinetic + e.strain}


def _line(x: Any, y: Any, points: int = POINTS) -> dict[str, Any]:
    return curves.line(x, y, points).model_dump()
