"""The page of a building's response, several cases side by side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from dampyr.phrases import sentence
from dampyr.show.figures.building import building_response
from dampyr.show.figures.control_comparison import controlled
from dampyr.show.figures.floor_loads import DRAWN, floor_loads
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.figures.loops_by_case import loops_by_case
from dampyr.show.figures.style import ACCELERATION, Axis, case_colours, input_axis
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.html_page import page
from dampyr.show.structures.floor_loads import loads_in_words
from dampyr.show.structures.response import errors_in_words
from dampyr.show.structures.responses import (
    WIDE,
    case_table,
    energy_table,
    floor_name,
    floor_table,
    interval_table,
    outcome,
)
from dampyr.show.table import Cell, Table
from dampyr.structures import Response
from dampyr.structures.ensembles.store import BARE
from dampyr.structures.time_history.respond import case_name
from dampyr.structures.time_history.responses import Responses

Array = NDArray[np.float64]
STROKE = Axis("stroke", "mm", 1e3)
FINE = 6  # points of a loop for each sample: some hundred in a turn of a stiff frame, which is smooth on paper


def html(result: Response | Responses, *, call: str = "") -> str:
    """The page of a response of `dampyr.structures.respond`, or of those at several inputs.

    It shows peaks and the damper's loops, energies, and the displacement of each floor. All cases share one ground motion
    and the same loads.
    """
    responses = result if isinstance(result, Responses) else Responses("", "", "", {case_name(result): result})
    cases = responses.cases
    first = next(iter(cases.values()))
    colours = case_colours(cases, BARE if BARE in cases else None)
    intervals = [interval_table(responses)] if responses.intervals else []
    with_loops: list[Block] = [case_table(responses), *_loops(cases, colours)]
    return page(
        f"Response: {first.title}",
        [
            Section("Peaks", [*to_look_at(responses.findings), *with_loops, Text("\n\n".join(outcome(responses)))]),
            Section(
                "Floors and energies", [*intervals, floor_table(responses), energy_table(responses), _steps(cases)]
            ),
            *_excitation(first),
            Section("Displacements", _displacements(cases, colours)),
            *([Section("Control", _control(cases, colours))] if any(any(r.laws) for r in cases.values()) else []),
        ],
        subtitle="; ".join(cases),
        call=call,
        origin=responses.origin,
    )


def _excitation(r: Response) -> list[Section]:
    """What moves the building: the ground, several supports, forces on the floors."""
    sections = []
    if r.shaken:
        figure = FigureBlock(ground_motion(r.time, r.ground_acceleration), "As applied.")
        sections.append(Section("The ground motion", [figure]))
    if r.supports:
        moved = dict(zip(r.supports, r.support_acceleration, strict=True))
        figure = FigureBlock(building_response(r.time, moved, axis=ACCELERATION), "Accelerations, as applied.")
        sections.append(Section("The motions of the supports", [figure]))
    if r.loads is not None:
        forces = dict(zip(r.loads.forces, r.load_forces, strict=True))
        drawn = (
            "As applied"
            if len(forces) <= DRAWN
            else f"The {DRAWN} of {len(forces)} loaded floors with the largest peaks"
        )
        figure = FigureBlock(floor_loads(r.time, forces), f"{drawn}; {loads_in_words(r.loads)}.")
        sections.append(Section("The loads on the floors", [figure]))
    return sections


def _steps(cases: Mapping[str, Response]) -> Table:
    """The scheme of each case, its step, and what the peaks changed by when it was halved."""
    rows: list[list[Cell]] = [[name, r.scheme, 1e3 * r.step, errors_in_words([r]) or None] for name, r in cases.items()]
    return Table(
        ("case", "scheme", "step", "error"),
        rows,
        ("", "", "ms", ""),
        caption="The steps in time, and what the peaks changed by when they were halved.",
        digits=4,
    )


def _displacements(cases: Mapping[str, Response], colours: Mapping[str, str]) -> list[FigureBlock]:
    first = next(iter(cases.values()))
    n, still = len(first.floors), "supports" if first.supports else "ground"
    drawn = range(n) if n <= WIDE else (0, n // 2 - 1, n - 1)
    return [
        FigureBlock(
            building_response(first.time, {name: r.displacement[k] for name, r in cases.items()}, colours=colours),
            sentence(
                f"{floor_name(first.floors[k])}: displacement relative to the {still}, and the largest "
                "sample of each case"
            ),
        )
        for k in drawn
    ]


def _control(cases: Mapping[str, Response], colours: Mapping[str, str]) -> list[FigureBlock]:
    """A figure for each site that has a law in some case: its stroke in all that have it, and the inputs."""
    blocks = []
    for site in dict.fromkeys(site for r in cases.values() for site in r.sites):
        with_damper = {name: r for name, r in cases.items() if site in r.sites}
        controlled_cases = {name: r for name, r in with_damper.items() if r.laws[r.sites.index(site)]}
        if controlled_cases:
            first = next(iter(controlled_cases.values()))
            axis = input_axis(first.input_units[first.sites.index(site)])
            strokes = {name: r.stroke[r.sites.index(site)] for name, r in with_damper.items()}
            inputs = {name: r.input[r.sites.index(site)] for name, r in controlled_cases.items()}
            means = {name: float(r.mean_input[r.sites.index(site)]) for name, r in controlled_cases.items()}
            blocks.append(
                FigureBlock(
                    controlled(first.time, strokes, inputs, STROKE, axis, colours=colours, means=means),
                    sentence(
                        f"{site}: stroke of the damper, and the input at the coil in the two seconds that are shaded"
                    ),
                )
            )
    return blocks


def _loops(cases: Mapping[str, Response], colours: Mapping[str, str]) -> list[FigureBlock]:
    """The loops of each damper of each case, on the same axes; nothing where no case has a damper."""
    loops, colour = {}, {}
    for name, r in cases.items():
        for d, site in enumerate(r.sites):
            panel = name if len(r.sites) == 1 else f"{name}, {site}"
            loops[panel], colour[panel] = between_samples(r.time, r.stroke[d], r.force[d]), colours[name]
    if not loops:
        return []
    first, sites = next(iter(cases.values())), {site for r in cases.values() for site in r.sites}
    which = f"the damper, {next(iter(sites))}" if len(sites) == 1 else "each damper"
    caption = (
        f"Force over stroke of {which}; samples every {1e3 * (first.time[1] - first.time[0]):.3g} ms, and between them a "
        "smooth curve through them."
    )
    return [FigureBlock(loops_by_case(loops, colour), caption)]


def between_samples(time: Array, stroke: Array, force: Array) -> tuple[Array, Array]:
    """A loop through its samples (n,) and, between them, points of a cubic spline of the stroke and of a monotone cubic of
    the force, which makes no peak that no sample has."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    fine = np.interp(np.arange(FINE * (len(time) - 1) + 1) / FINE, np.arange(len(time)), time)
    return CubicSpline(time, stroke)(fine), PchipInterpolator(time, force)(fine)
