"""The page of a hybrid test: the building with the force of the test, beside the one that is all computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dampyr.hybrid.hybrid_result import Array, HybridResult
from dampyr.origin import OriginKind
from dampyr.phrases import sentence
from dampyr.show.figures.building import building_response
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.figures.loops import loops
from dampyr.show.figures.style import DISPLACEMENT, input_axis
from dampyr.show.hybrid.hybrid_result import decided, outcome, peaks_table
from dampyr.show.pages.blocks import FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.structures.responses import floor_name

FORCES: Mapping[OriginKind, str] = {
    "measured": "The building was computed and its damper measured",
    "simulated": "The building was computed, and the force of its damper is that of a simulated test rig",
    "virtual": "No rig took part: building, actuator and damper were computed",
    "derived": "The building was computed and its damper tested",
    "not stated": "The building was computed and its damper tested",
}


def html(result: HybridResult, *, call: str = "") -> str:
    """The page of a hybrid test."""
    computed = result.computed
    peaks = replace(peaks_table(result), caption="Peak displacements relative to the ground.")
    return page(
        f"{result.tested.capitalize()}: {result.title}",
        [
            Section("In short", [Text(in_short(result)), *to_look_at(result.findings), peaks]),
            Section("The floors", [_floor(result, k) for k in range(len(computed.floors))]),
            Section("The damper", _damper(result)),
            Section(
                "The ground motion",
                [FigureBlock(ground_motion(computed.time, computed.ground_acceleration), "As applied, scaled.")],
            ),
        ],
        subtitle=f"{computed.title}; record scaled to {result.scale:g}, {result.input_words} at the coil",
        provenance={
            "clock": "the building's own"
            if result.clock == 1.0
            else f"{result.clock:g} times slower than the building's",
            "static force": "none: the damper is its model"
            if result.origin.kind == "virtual"
            else f"{result.static_force:.4g} N, {result.origin.series} before the test and taken from the force",
            "computed": f"{computed.scheme}, step {1e3 * computed.step:.4g} ms",
        },
        call=call,
        origin=result.origin,
    )


def in_short(result: HybridResult) -> str:
    """What the test has shown, in sentences."""
    slower = f"{result.clock:g}"
    clock = f" on a clock {slower} times slower" if slower != "1" else ""
    step_by_step = (
        f"{FORCES[result.origin.kind]}, step by step{clock}; the ground motion was scaled to {result.scale:g}."
    )
    return " ".join((step_by_step, *outcome(result)))


def _floor(result: HybridResult, floor: int) -> FigureBlock:
    name = floor_name(result.computed.floors[floor])
    return FigureBlock(
        building_response(result.time, result.histories(floor)),
        sentence(f"{name}: displacement relative to the ground, in the building's time"),
    )


def _inputs(result: HybridResult, inputs: Array) -> FigureBlock:
    computed = np.interp(result.time, result.computed.time, result.computed.input[0])
    return FigureBlock(
        building_response(result.time, {"computed": computed, "asked": inputs}, input_axis(result.input_unit)),
        f"The input: {result.law}. As the law asked for it in the test, and as it is in the computed response, where the coil "
        f"follows the law with its lag. {decided(result)}.",
    )


def _damper(result: HybridResult) -> list[FigureBlock]:
    moved = {"wanted": result.target, "achieved": result.achieved}
    velocity = np.gradient(result.achieved, result.time) / result.clock
    asked = [] if result.inputs is None else [_inputs(result, result.inputs)]
    return [
        FigureBlock(
            building_response(result.time, moved, DISPLACEMENT),
            "The damper's stroke: as the building wants it, and as it was achieved.",
        ),
        *asked,
        FigureBlock(
            loops(result.achieved, velocity, result.force, {"model": result.modelled}, record_origin=result.origin),
            f"The damper's loops: {result.origin.series}, less the static force, and the model along the same path.",
        ),
    ]
