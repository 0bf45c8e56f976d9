"""The page of a hybrid test: the building with the force of the test, beside the one that is all computed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dampyr.figures.building import building_response
from dampyr.figures.ground_motion import ground_motion
from dampyr.figures.loops import loops
from dampyr.figures.style import DISPLACEMENT
from dampyr.hybrid import HybridResult
from dampyr.origin import OriginKind
from dampyr.report.blocks import FigureBlock, Section, Table, Text, to_look_at
from dampyr.report.html_page import page, write_page
from dampyr.report.response_page import floor_name
from dampyr.representation import sentence

FORCES: Mapping[OriginKind, str] = {
    "measured": "The building was computed and its damper measured",
    "simulated": "The building was computed, and the force of its damper is that of a simulated test rig",
    "virtual": "No rig took part: building, actuator and damper were computed",
    "derived": "The building was computed and its damper tested",
    "not stated": "The building was computed and its damper tested",
}


def write_hybrid_page(result: HybridResult, path: str | Path) -> Path:
    """Write the page of a hybrid test and return its path."""
    computed = result.computed
    html = page(
        f"{result.tested.capitalize()}: {result.title}",
        [
            Section("In short", [Text(in_short(result)), *to_look_at(result.findings), _peaks(result)]),
            Section("The floors", [_floor(result, k) for k in range(len(computed.floors))]),
            Section("The damper", _damper(result)),
            Section(
                "The ground motion",
                [FigureBlock(ground_motion(computed.time, computed.ground_acceleration), "As applied, scaled.")],
            ),
        ],
        subtitle=f"{computed.title}; record scaled to {result.scale:g}, {result.voltage:g} V at the coil",
        provenance={
            "clock": "the building's own"
            if result.clock == 1.0
            else f"{result.clock:g} times slower than the building's",
            "static force": "none: the damper is its model"
            if result.origin.kind == "virtual"
            else f"{result.static_force:.4g} N, {result.origin.series} before the test and taken from the force",
            "computed": f"{computed.scheme}, step {1e3 * computed.step:.4g} ms",
        },
        call=f"dampyr.report.write_hybrid_page(result, {Path(path).name!r})",
        origin=result.origin,
    )
    return write_page(path, html)


def in_short(result: HybridResult) -> str:
    """What the test has shown, in sentences."""
    worst = int(np.argmax(np.abs(result.differences)))
    by = 100 * result.differences[worst]
    slower = f"{result.clock:g}"
    clock = f" on a clock {slower} times slower" if slower != "1" else ""
    virtual = result.origin.kind == "virtual"
    errors = "the actuator's error and the loop's" if virtual else "the model's error, the table's and the loop's"
    moved = "computed actuator" if virtual else "table"
    return (
        f"{FORCES[result.origin.kind]}, step by step{clock}; the ground motion was scaled to {result.scale:g}. The peaks "
        f"differ by up to {by:+.2g} % ({floor_name(result.computed.floors[worst])}) from the response with the damper's model "
        f"in its place: this is {errors} together. The {moved} followed what the building wanted to "
        f"{100 * result.tracking_error:.2g} % rms, {1e3 * result.lag:.2g} ms late "
        f"in the building's time after compensation; its errors put {100 * result.energy_error:.2g} % of the ground's energy "
        "into the building."
    )


def _peaks(result: HybridResult) -> Table:
    heads = ("", result.tested, "computed", "difference")
    computed = result.computed
    rows = [
        [floor_name(name), 1e3 * ours, 1e3 * theirs, 100 * by]
        for name, ours, theirs, by in zip(
            computed.floors, result.peaks, computed.peak_displacement, result.differences, strict=True
        )
    ]
    return Table(heads, rows, ("", "mm", "mm", "%"), caption="Peak displacements relative to the ground.", digits=4)


def _floor(result: HybridResult, floor: int) -> FigureBlock:
    name = floor_name(result.computed.floors[floor])
    return FigureBlock(
        building_response(result.time, result.histories(floor)),
        sentence(f"{name}: displacement relative to the ground, in the building's time"),
    )


def _damper(result: HybridResult) -> list[FigureBlock]:
    moved = {"wanted": result.target, "achieved": result.achieved}
    velocity = np.gradient(result.achieved, result.time) / result.clock
    return [
        FigureBlock(
            building_response(result.time, moved, DISPLACEMENT),
            "The damper's stroke: as the building wants it, and as it was achieved.",
        ),
        FigureBlock(
            loops(result.achieved, velocity, result.force, {"model": result.modelled}, record_origin=result.origin),
            f"The damper's loops: {result.origin.series}, less the static force, and the model along the same path.",
        ),
    ]
