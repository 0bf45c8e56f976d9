"""The page of a building's response, several cases side by side."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.figures.building import building_response
from dampyr.figures.control_comparison import controlled
from dampyr.figures.ground_motion import ground_motion
from dampyr.figures.loops import loops
from dampyr.figures.style import CURRENT, VOLTAGE, Axis, case_colours
from dampyr.ground_motions import end_in_words
from dampyr.report.blocks import Cell, FigureBlock, Section, Table, Text, to_look_at
from dampyr.report.html_page import page, write_page
from dampyr.representation import sentence
from dampyr.structures import Response, Simulated
from dampyr.structures.time_history.simulate import BARE

Array = NDArray[np.float64]
STROKE = Axis("stroke", "mm", 1e3)
WIDE = 8  # floors that a table has columns for, and a page figures of each
FINE = 6  # points of a loop for each sample: some hundred in a turn of a stiff frame, which is smooth on paper


def write_response_page(cases: Simulated | Mapping[str, Response], path: str | Path) -> Path:
    """Write the page of the result of `dampyr.structures.simulate`, or of cases by name.

    It shows peaks, energies, the displacement of each floor and the damper's loops. All cases share one ground motion.
    """
    simulated = cases if isinstance(cases, Simulated) else Simulated("", "", "", cases)
    intervals = [_intervals(cases)] if isinstance(cases, Simulated) and cases.intervals else []
    cases = cases.cases if isinstance(cases, Simulated) else cases
    notes = [simulated.note] if simulated.note else []
    first = next(iter(cases.values()))
    colours = case_colours(cases, BARE if BARE in cases else None)
    said = [*to_look_at(simulated.findings), *[Text(sentence(text)) for text in notes]]
    html = page(
        f"Response: {first.title}",
        [
            Section("Peaks", [*said, _peaks(cases), *intervals, _energies(cases)]),
            Section(
                "The ground motion",
                [FigureBlock(ground_motion(first.time, first.ground_acceleration), "As applied.")],
            ),
            Section("Displacements", _displacements(cases, colours)),
            *([Section("Control", _control(cases, colours))] if any(any(r.laws) for r in cases.values()) else []),
            Section("The dampers' loops", _loops(cases, colours)),
        ],
        subtitle="; ".join(cases),
        provenance={name: _accuracy(r) for name, r in cases.items()},
        call=f"dampyr.report.write_response_page(result, {Path(path).name!r})",
        origin=simulated.origin,
    )
    return write_page(path, html)


def _accuracy(r: Response) -> str:
    """The scheme, its step, and what the peaks changed by when it was halved."""
    text = f"{r.scheme}, step {1e3 * r.step:.4g} ms"
    return f"{text}; error {r.error_in_words}" if r.error_in_words else text


def _peaks(cases: Mapping[str, Response]) -> Table:
    floors = next(iter(cases.values())).floors
    many = len(floors) > WIDE
    rows = []
    for name, r in cases.items():
        displacement = [max(r.peak_displacement)] if many else r.peak_displacement
        largest = [
            1e3 * max(r.peak_drift),
            max(r.peak_acceleration),
            r.peak_base_shear,
            max(r.peak_force, default=None),
        ]
        rows.append([name, *(1e3 * peak for peak in displacement), *largest])
    columns = [f"largest of {len(floors)} floors"] if many else [floor_name(floor) for floor in floors]
    return Table(
        ("case", *columns, "largest drift", "largest acceleration", "base shear", "damper force"),
        rows,
        ("", *("mm" for _ in columns), "mm", "m/s²", "N", "N"),
        caption="Peaks inside the step; displacements relative to the ground, accelerations absolute. "
        f"The response {end_in_words(next(iter(cases.values())).after)}.",
    )


def _intervals(result: Simulated) -> Table:
    """The 90 % intervals of the peaks of the cases with a damper."""
    floors = next(iter(result.cases.values())).floors
    many = len(floors) > WIDE
    rows: list[list[Cell]] = []
    for name, each in result.intervals.items():
        peaks = each["peak_displacement_m"]
        spans = [(1e3, peaks.max(axis=1))] if many else [(1e3, peaks[:, k]) for k in range(len(floors))]
        spans += [(1e3, each["peak_drift_m"].max(axis=1)), (1.0, each["peak_acceleration_m_s2"].max(axis=1))]
        spans.append((1.0, each["peak_force_N"].max(axis=1)))
        rows.append([name, *(f"{factor * low:.4g} to {factor * high:.4g}" for factor, (low, high) in spans)])
    columns = [f"largest of {len(floors)} floors"] if many else [floor_name(floor) for floor in floors]
    return Table(
        ("case", *columns, "largest drift", "largest acceleration", "damper force"),
        rows,
        ("", *("mm" for _ in columns), "mm", "m/s²", "N"),
        caption=f"90 % intervals of the peaks, from {result.draws} dampers drawn from the covariance of the card, with the "
        "levels of records and sessions where the card has them.",
    )


def _energies(cases: Mapping[str, Response]) -> Table:
    rows = [
        [name, e.input[-1], e.viscous[-1], e.damper[-1], e.kinetic[-1] + e.strain[-1], e.residual[-1]]
        for name, e in ((name, r.energy) for name, r in cases.items())
    ]
    return Table(
        ("case", "input", "viscous", "dampers", "still in motion", "residual"),
        rows,
        ("", "J", "J", "J", "J", "J"),
        caption="Where the energy went by the end; the residual is the error of the balance.",
        digits=4,
    )


def floor_name(label: str) -> str:
    """``floor 1`` for a floor called 1; a name of its own, such as roof, stays."""
    return f"floor {label}" if label.isdigit() else label


def _displacements(cases: Mapping[str, Response], colours: Mapping[str, str]) -> list[FigureBlock]:
    first = next(iter(cases.values()))
    n = len(first.floors)
    drawn = range(n) if n <= WIDE else (0, n // 2 - 1, n - 1)
    return [
        FigureBlock(
            building_response(first.time, {name: r.displacement[k] for name, r in cases.items()}, colours=colours),
            sentence(
                f"{floor_name(first.floors[k])}: displacement relative to the ground, and the largest sample of each case"
            ),
        )
        for k in drawn
    ]


def _control(cases: Mapping[str, Response], colours: Mapping[str, str]) -> list[FigureBlock]:
    """A figure for each site that has a law in some case: its stroke in all that have it, and the inputs."""
    blocks = []
    for site in dict.fromkeys(site for r in cases.values() for site in r.sites):
        there = {name: r for name, r in cases.items() if site in r.sites}
        ruled = {name: r for name, r in there.items() if r.laws[r.sites.index(site)]}
        if ruled:
            first = next(iter(ruled.values()))
            axis = VOLTAGE if first.input_units[first.sites.index(site)] == "V" else CURRENT
            strokes = {name: r.stroke[r.sites.index(site)] for name, r in there.items()}
            inputs = {name: r.input[r.sites.index(site)] for name, r in ruled.items()}
            blocks.append(
                FigureBlock(
                    controlled(first.time, strokes, inputs, STROKE, axis, colours=colours),
                    sentence(f"{site}: stroke of the damper, and the input at the coil"),
                )
            )
    return blocks


def _loops(cases: Mapping[str, Response], colours: Mapping[str, str]) -> list[FigureBlock | Text]:
    blocks: list[FigureBlock | Text] = []
    for name, r in cases.items():
        for d, site in enumerate(r.sites):
            stroke, force = between_samples(r.time, r.stroke[d], r.force[d])
            every = f"{1e3 * (r.time[1] - r.time[0]):.3g} ms"
            caption = f"{name}: damper, {site}; samples every {every}, and between them a smooth curve through them"
            figure = loops(stroke, None, None, {name: force}, colours=colours, points=len(stroke))
            blocks.append(FigureBlock(figure, sentence(caption)))
    return blocks or [Text("No case has a damper.")]


def between_samples(time: Array, stroke: Array, force: Array) -> tuple[Array, Array]:
    """A loop through its samples (n,) and, between them, points of a cubic spline of the stroke and of a monotone cubic of
    the force, which makes no peak that no sample has."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    fine = np.interp(np.arange(FINE * (len(time) - 1) + 1) / FINE, np.arange(len(time)), time)
    return CubicSpline(time, stroke)(fine), PchipInterpolator(time, force)(fine)
