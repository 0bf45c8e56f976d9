"""The page of a building's response, several cases side by side."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from dampyr.figures.building import building_response
from dampyr.figures.control_comparison import controlled
from dampyr.figures.ground_motion import ground_motion
from dampyr.figures.loops import loops
from dampyr.figures.style import CURRENT, VOLTAGE, Axis
from dampyr.ground_motions import end_in_words
from dampyr.report.blocks import FigureBlock, Section, Table, Text
from dampyr.report.html_page import page, write_page
from dampyr.structures import Response, Simulated

STROKE = Axis("stroke", "mm", 1e3)


def write_response_page(cases: Simulated | Mapping[str, Response], path: Path) -> Path:
    """Write the page of the result of `dampyr.structures.simulate`, or of cases by name.

    It shows peaks, energies, the displacement of each floor and the damper's loops. All cases share one ground motion.
    """
    cases = cases.cases if isinstance(cases, Simulated) else cases
    first = next(iter(cases.values()))
    html = page(
        f"Response: {first.title}",
        [
            Section("Peaks", [_peaks(cases), _energies(cases)]),
            Section("Displacements", _displacements(cases)),
            *([Section("Control", _control(cases))] if any(any(r.laws) for r in cases.values()) else []),
            Section("The dampers' loops", _loops(cases)),
            Section(
                "The ground motion",
                [FigureBlock(ground_motion(first.time, first.ground_acceleration), "As applied.")],
            ),
        ],
        subtitle="; ".join(cases),
        provenance={name: f"{r.scheme}, step {1e3 * r.step:.4g} ms" for name, r in cases.items()},
    )
    write_page(path, html)
    return path


def _peaks(cases: Mapping[str, Response]) -> Table:
    rows = [
        [name, *(1e3 * r.peak_displacement), 1e3 * max(r.peak_drift), max(r.peak_acceleration), r.peak_base_shear,
         max(r.peak_force, default=None)]
        for name, r in cases.items()
    ]  # fmt: skip
    floors = next(iter(cases.values())).floors
    return Table(
        ("case", *floors, "largest drift", "largest acceleration", "base shear", "damper force"),
        rows,
        ("", *("mm" for _ in floors), "mm", "m/s²", "N", "N"),
        caption="Peaks inside the step; displacements relative to the ground, accelerations absolute. "
        f"The response {end_in_words(next(iter(cases.values())).after)}.",
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


def _displacements(cases: Mapping[str, Response]) -> list[FigureBlock]:
    first = next(iter(cases.values()))
    return [
        FigureBlock(
            building_response(first.time, {name: r.displacement[k] for name, r in cases.items()}),
            f"{floor}: displacement relative to the ground.",
        )
        for k, floor in enumerate(first.floors)
    ]


def _control(cases: Mapping[str, Response]) -> list[FigureBlock]:
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
                    controlled(first.time, strokes, inputs, STROKE, axis), f"{site}: stroke, and input at the coil."
                )
            )
    return blocks


def _loops(cases: Mapping[str, Response]) -> list[FigureBlock | Text]:
    blocks: list[FigureBlock | Text] = [
        FigureBlock(loops(r.stroke[d], None, None, {"force": r.force[d]}), f"{name}: damper, {site}.")
        for name, r in cases.items()
        for d, site in enumerate(r.sites)
    ]
    return blocks or [Text("No case has a damper.")]
