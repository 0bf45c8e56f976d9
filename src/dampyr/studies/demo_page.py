"""The page of the demonstration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import dampyr
from dampyr.records import Record, measure
from dampyr.report import (
    FigureBlock,
    Section,
    Table,
    Text,
    building_response,
    history,
    loops,
    page,
    scores,
    write_page,
)
from dampyr.report.fit_sections import fit_blocks, score_table

if TYPE_CHECKING:
    from dampyr.studies.demo import Array, Demo


def write_report(demo: Demo, path: Path) -> Path:
    """Write ``report.html``: one file, no network."""
    best, worst = (100 * f(s.l1 for s in demo.scores.values()) for f in (min, max))
    html = page(
        "From the shaking table to the building",
        [_tests(demo), _identified(demo), _validated(demo), _building(demo)],
        subtitle=f"A simulated campaign of {len(demo.fitted) + len(demo.held_out)} tests. The identified damper predicts tests "
        f"that it never saw to {best:.1f}–{worst:.1f} % (L1 ratio).",
        provenance={
            "made by": f"dampyr {dampyr.__version__}, dampyr demo",
            "records": "simulated: not measurements",
            "earthquake": "El Centro 1940 NS, Peknold's version",
            "building": "two storeys, chapter 5 of Raminelli (2020)",
        },
    )
    write_page(path, html)
    return path


def _tests(demo: Demo) -> Section:
    rows = []
    for record in demo.fitted + demo.held_out:
        measured = measure(record)
        rows.append(
            [record.name, record.input_value, 1e3 * measured.peak_to_peak_m, measured.frequency_hz, 1e3 * measured.peak_speed,
             measured.mean_force, "held out" if record.role == "validation" else "fitted"]
        )  # fmt: skip
    return Section(
        "The tests",
        [
            Text(
                "The specimen is a simulated damper with the force F0 + k x + c v + Fy tanh((v + s x)/v0), its parameters over "
                "the voltage as fitted to the published campaign. The instruments count the displacement in steps of 5 µm, "
                "add 1.5 N of noise to the force, round it to 0.187 N, are 6 ms late with it, and start each test "
                "with another zero. What follows sees the records alone."
            ),
            Table(
                ("record", "voltage", "peak to peak", "frequency", "peak speed", "mean force", "used"),
                rows,
                ("", "V", "mm", "Hz", "mm/s", "N", ""),
                caption="As measured from the records, over whole cycles.",
                digits=4,
            ),
        ],
    )


def _identified(demo: Demo) -> Section:
    from dampyr.studies.demo import MODEL

    return Section(
        "The identified damper",
        [
            Text(
                f"One joint fit of the model {MODEL} to all fitted tests; it is not the model that made the records, so what "
                "it cannot follow stays visible. Each record kept its own offset and initial state. "
                f"The card is in {demo.card.name}."
            ),
            *fit_blocks(demo.fit),
        ],
    )


def _validated(demo: Demo) -> Section:
    shown = max(demo.held_out, key=lambda r: demo.scores[r.name].l1)
    model = demo.predictions[shown.name] + demo.scores[shown.name].offset
    window = demo.scores[shown.name].window.slice
    groups = {
        "fitted tests": [s.l1 for s in demo.fit.scores.values()],
        "tests it never saw": [s.l1 for s in demo.scores.values()],
    }
    return Section(
        "Tests it never saw",
        [
            score_table(
                demo.scores,
                "A free run of the card along each record from 2 s after its motion starts; only the offset is taken from it. "
                "1.4 V and 2.6 V lie between the voltages of the fit.",
            ),
            FigureBlock(scores(groups), "L1 ratio of each record: fitted ones, and ones that the fit never saw."),
            FigureBlock(
                loops(
                    shown.displacement[window],
                    velocity_of(shown)[window],
                    shown.force[window],
                    {"card": model[window]},
                ),
                f"The worst of them, {shown.name}: measured and predicted loops.",
            ),
            FigureBlock(
                history(shown.time[window], shown.force[window], model[window], name="card"),
                f"{shown.name}: measured and predicted force, and what is left.",
            ),
        ],
    )


def velocity_of(record: Record) -> Array:
    """The velocity that is plotted: with the bandwidth of the fit."""
    from dampyr.models.numerics.differentiation import differentiate

    return differentiate(record.time, record.displacement, 15.0)


def _building(demo: Demo) -> Section:
    rows = []
    bare = demo.responses["no damper"]
    for name, r in demo.responses.items():
        rows.append(
            [name, 1e3 * r.peak_displacement[0], 1e3 * r.peak_displacement[-1], 1e3 * max(r.peak_drift),
             max(r.peak_acceleration), max(r.peak_force, default=0.0), 100 * r.peak_drift[0] / bare.peak_drift[0]]
        )  # fmt: skip
    first = {name: r.displacement[0] for name, r in demo.responses.items()}
    return Section(
        "The building in the earthquake",
        [
            Text(
                "The two-storey building of chapter 5 under El Centro 1940 with the identified damper in the first storey. "
                "The lag belongs to the rig's force channel and is left out here, and so is the static offset. The motion "
                "goes beyond the calibrated stroke and speed, so these are extrapolations of the tests."
            ),
            Table(
                (
                    "case",
                    "first floor",
                    "roof",
                    "largest drift",
                    "largest acceleration",
                    "damper force",
                    "first drift",
                ),
                rows,
                ("", "mm", "mm", "mm", "m/s²", "N", "% of bare"),
                caption="Peaks; displacements relative to the ground, accelerations absolute.",
                digits=4,
            ),
            FigureBlock(building_response(bare.time, first), "Displacement of the first floor."),
        ],
    )
