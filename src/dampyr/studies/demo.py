"""Demonstration of the whole chain: a campaign on the simulated rig, identification, validation, a building in an earthquake.

The specimen is that of the simulated rig, fitted to the records of the published campaign:
F0 + k x + c v + Fy tanh((v + s x)/v0). The model that is identified is another one, so the demonstration shows a misfit as a
real damper would.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr import campaigns, ground_motions, structures
from dampyr.campaigns.journal import NAME as JOURNAL
from dampyr.errors import FindingWarning
from dampyr.findings import as_dicts, besides, worst_first
from dampyr.identification import Fit, Score, fit, score
from dampyr.identification.scoring.score import prediction
from dampyr.models import Damper
from dampyr.models.numerics.differentiation import differentiate
from dampyr.origin import Origin
from dampyr.records import Record, measure, read, read_campaign, write
from dampyr.rig import RigSettings, simulated
from dampyr.rig.specimen import original_specimen
from dampyr.show.figures.building import building_response
from dampyr.show.figures.history import history
from dampyr.show.figures.loops import loops
from dampyr.show.figures.scores import scores
from dampyr.show.identification.validation import score_table
from dampyr.show.pages.blocks import FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.fit_sections import fit_blocks
from dampyr.show.pages.html_page import page, write_html
from dampyr.show.table import Table
from dampyr.structures.time_history.responses import Responses

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]

MODEL = "dahl + hyperbolic_tangent + spring + delay"
FIXED = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}  # one dashpot, that of dahl; no shift
LAWS = {"dahl.rho": "constant", "delay.tau": "constant"}  # one pre-sliding path, and one lag: the rig's
VOLTAGES = (0.0, 0.8712, 1.98, 3.212)  # V, of the published campaign
SINES = ((24, 0.65), (18, 0.85), (13, 1.1), (8, 1.2))  # peak to peak mm, Hz; 49 mm/s are possible at 3.212 V
HELD_OUT = (  # V, peak to peak mm, Hz
    (0.0, 15, 1.0),
    (0.8712, 20, 0.7),
    (1.4, 14, 0.9),
    (1.98, 10, 1.05),
    (2.6, 12, 0.8),
    (3.212, 9, 1.0),
)
CYCLES = 5  # steady ones; the scores begin 2 s after the motion starts
RATE = 100.0  # samples/s, as the original rig's
BLOCK = 0.07  # s read at once: the longest with two blocks in the watchdog's 0.15 s, so the fewest exchanges
BANDWIDTH = 15.0  # Hz of the velocity: 12 times the highest frequency
SEED = 2020  # of the simulated noise


def campaign() -> campaigns.Campaign:
    """The tests: sines at four voltages, then those that are held out of the fit."""
    sines = [(voltage, *sine) for voltage in VOLTAGES for sine in SINES] + list(HELD_OUT)
    steps = [
        {"kind": "sine", "peak_to_peak": f"{size} mm", "frequency": f"{frequency} Hz", "voltage": f"{voltage} V",
         "cycles": CYCLES, "rest_before": "1 s"}
        for voltage, size, frequency in sines
    ]  # fmt: skip
    return campaigns.campaign_of({"name": "demo", "rest_between": "0 s", "step": steps})


def rig_settings() -> RigSettings:
    """The original rig, sampled as the original campaign was."""
    settings = RigSettings()
    return replace(settings, board=replace(settings.board, rate=RATE, block=BLOCK, velocity_bandwidth=BANDWIDTH))


@dataclass(frozen=True)
class Demo:
    """Results of the demonstration: records, the fit, its scores on the held-out tests, and the building's responses."""

    folder: Path
    fitted: list[Record]
    held_out: list[Record]
    fit: Fit
    scores: dict[str, Score]
    predictions: dict[str, Array]
    responses: dict[str, Any]
    with_specimen: dict[str, Any]
    """The same building with the specimen in the place of what was identified: known here, as the specimen is simulated."""

    @property
    def origin(self) -> Origin:
        """Simulated, as its records are."""
        return self.fit.origin

    @property
    def of_building(self) -> Responses:
        """The responses as `dampyr.structures.respond` gives those of several inputs."""
        return Responses("two-storey building", "El Centro", "V", self.responses)

    @property
    def card(self) -> Path:
        """The file of the identified damper."""
        return self.folder / "damper.toml"

    def off_by(self, case: str) -> float:
        """Of the first floor's peak with the identified damper, from that with the specimen, in %."""
        ours, true = (float(r[case].peak_displacement[0]) for r in (self.responses, self.with_specimen))
        return 100.0 * (ours - true) / true

    def summary(self) -> dict[str, Any]:
        """The figures of the page as plain numbers, SI."""
        return {
            "model": MODEL,
            "origin": self.origin.as_dict(),
            "converged": self.fit.converged,
            "reason": self.fit.reason,
            "findings": as_dicts(worst_first(self.fit.findings, self.of_building.findings)),
            "parameters": self.fit.parameters,
            "stderr": self.fit.stderr,
            "within_records_only": list(self.fit.within_records),
            "l1_fitted": {name: s.l1 for name, s in self.fit.scores.items()},
            "l1_held_out": {name: s.l1 for name, s in self.scores.items()},
            "peak_displacement_m": {name: r.peak_displacement for name, r in self.responses.items()},
            "peak_displacement_with_specimen_m": {name: r.peak_displacement for name, r in self.with_specimen.items()},
            "card": self.card,
            "records": self.folder / "records",
        }


def demo(folder: str | Path, progress: Progress = lambda stage, done: None) -> Demo:
    """Run the chain and leave records, the card and ``report.html`` in ``folder``."""
    out = Path(folder)
    fitted, held_out = _perform(out / "records", progress)
    progress("identifying", 0.0)
    fit_result = fit(fitted, MODEL, laws=LAWS, fixed=FIXED, bandwidth=BANDWIDTH, progress=progress)
    if fit_result.damper is None:
        raise RuntimeError(f"the demonstration's fit gave no damper: {fit_result.reason}")
    fit_result.damper.save(out / "damper.toml")
    scores, predictions = {}, {}
    for k, record in enumerate(held_out):
        progress("validating on the held-out tests", k / len(held_out))
        scores[record.name] = score(fit_result.damper, record)
        predictions[record.name] = prediction(fit_result.damper, record)
    progress("validating on the held-out tests", 1.0)
    identified = fit_result.damper.without("delay")  # it is the rig's
    responses = _responses(identified, progress)
    with_specimen = _responses(original_specimen(), lambda stage, done: None)
    result = Demo(out, fitted, held_out, fit_result, scores, predictions, responses, with_specimen)
    progress("writing the report", 0.0)
    write_report(result, out / "report.html")
    progress("writing the report", 1.0)
    return result


def _perform(folder: Path, progress: Progress) -> tuple[list[Record], list[Record]]:
    """Perform the campaign on the simulated rig, mark the held-out tests, and read the records from the disk."""
    stage = "testing on the simulated rig"
    progress(stage, 0.0)
    for old in [*folder.glob("*.h5"), *folder.glob(f"{JOURNAL}*")]:
        old.unlink()
    with simulated(rig_settings(), seed=SEED) as rig:
        campaigns.perform(campaign(), rig, folder, lambda now: progress(stage, now.done / now.total))
    for path in sorted(folder.glob("*.h5"))[-len(HELD_OUT) :]:
        write(read(path).replace(note="held out of the fit", role="validation"), path)
    progress(stage, 1.0)
    return read_campaign(folder, role="fit"), read_campaign(folder, role="validation")


def _responses(damper: Damper, progress: Progress) -> dict[str, Any]:
    """Three cases of the chapter-5 building under El Centro."""
    building, motion = structures.two_storey(), ground_motions.el_centro()
    cases: dict[str, dict[str, Any]] = {
        "no damper": {},
        "damper at 0 V": {"dampers": {1: damper}, "voltage": 0.0},
        "damper at 3.212 V": {"dampers": {1: damper}, "voltage": 3.212},
    }
    responses = {}
    for k, (name, options) in enumerate(cases.items()):
        progress("simulating the building", k / len(cases))
        with warnings.catch_warnings():  # what it warns of stands on the page, and below the table
            warnings.simplefilter("ignore", FindingWarning)
            responses[name] = structures.respond(building, motion, **options)
    progress("simulating the building", 1.0)
    return responses


def write_report(demo: Demo, path: Path) -> Path:
    """Write ``report.html``: one file, no network."""
    best, worst = (100 * f(s.l1 for s in demo.scores.values()) for f in (min, max))
    html = page(
        "From the shaking table to the building",
        [_tests(demo), _identified(demo), _validated(demo), _building(demo)],
        subtitle=f"A simulated campaign of {len(demo.fitted) + len(demo.held_out)} tests. The identified damper predicts the "
        f"held-out tests to {best:.1f}–{worst:.1f} % (L1 ratio).",
        provenance={
            "earthquake": "El Centro 1940 NS, Peknold's version",
            "building": "two storeys, chapter 5 of Raminelli (2020)",
        },
        origin=demo.origin,
    )
    write_html(path, html)
    return path


def _tests(demo: Demo) -> Section:
    settings, rows = rig_settings(), []
    resolution = 2.0 * settings.board.range / 2**settings.board.bits * settings.load_cell.scale
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
                "A campaign of tapered sines, checked and then performed on the simulated rig, a model of the original shaking "
                "table with its actuator, controller and instruments. Its specimen has the force "
                "F0 + k x + c v + Fy tanh((v + s x)/v0), with parameters over the voltage as fitted to the published campaign. "
                f"The encoder counts in steps of {1e6 * settings.encoder.count:g} µm; the load cell has "
                f"{settings.load_cell.noise:g} N rms of noise, {settings.load_cell.wander:g} N rms of slow errors and steps of "
                f"{resolution:.3g} N; {RATE:g} samples are taken per second. The following sections use the records only."
            ),
            Table(
                ("record", "voltage", "peak to peak", "frequency", "peak speed", "mean force", "used"),
                rows,
                ("", "V", "mm", "Hz", "mm/s", "N", ""),
                caption="Measured from the records, over whole cycles.",
                digits=4,
            ),
        ],
    )


def _identified(demo: Demo) -> Section:
    verdict = demo.fit.verdict
    return Section(
        "The identified damper",
        [
            Text(
                f"One joint fit of the model {MODEL} to all fitted tests. Its shift s is one number, where the specimen's "
                "depends on the voltage, so a misfit remains. Each record has its own offset and initial state. "
                f"The card is in {demo.card.name}."
            ),
            *fit_blocks(demo.fit),
            Text(verdict.words),
            *to_look_at(besides(demo.fit.findings, [verdict.words])),
        ],
    )


def _validated(demo: Demo) -> Section:
    worst = max(demo.held_out, key=lambda r: demo.scores[r.name].l1)
    model = demo.predictions[worst.name] + demo.scores[worst.name].offset
    window = demo.scores[worst.name].window.slice
    groups = {
        "fitted tests": [s.l1 for s in demo.fit.scores.values()],
        "held-out tests": [s.l1 for s in demo.scores.values()],
    }
    return Section(
        "Held-out tests",
        [
            score_table(
                demo.scores,
                "A free run of the card along each record from 2 s after its motion starts; only the offset is adjusted to it. "
                "1.4 V and 2.6 V lie between the voltages of the fit.",
            ),
            FigureBlock(scores(groups), "L1 ratio of each record, fitted and held out."),
            FigureBlock(
                loops(
                    worst.displacement[window],
                    velocity_of(worst)[window],
                    worst.force[window],
                    {"card": model[window]},
                    record_origin=worst.origin,
                ),
                f"The worst of them, {worst.name}: simulated and predicted loops.",
            ),
            FigureBlock(
                history(
                    worst.time[window], worst.force[window], model[window], name="card", record_origin=worst.origin
                ),
                f"{worst.name}: simulated and predicted force, and the residual.",
            ),
        ],
    )


def velocity_of(record: Record) -> Array:
    """The velocity that is plotted: with the bandwidth of the fit."""
    return differentiate(record.time, record.displacement, BANDWIDTH)


def _building(demo: Demo) -> Section:
    rows = []
    bare = demo.responses["no damper"]
    for name, r in demo.responses.items():
        rows.append(
            [name, 1e3 * r.peak_displacement[0], 1e3 * r.peak_displacement[-1], 1e3 * max(r.peak_drift),
             max(r.peak_acceleration), max(r.peak_force, default=0.0), 100 * r.peak_drift[0] / bare.peak_drift[0],
             1e3 * demo.with_specimen[name].peak_displacement[0], demo.off_by(name)]
        )  # fmt: skip
    first = {name: r.displacement[0] for name, r in demo.responses.items()}
    return Section(
        "The building in the earthquake",
        [
            Text(
                "The two-storey building of chapter 5 under El Centro 1940 with the identified damper in the first storey. "
                "The static offset and the rig's delay are left out. The motion exceeds the calibrated stroke and "
                "speed, so these are extrapolations of the tests. What that costs can be told here alone, as the specimen is "
                "simulated: the last two columns have the building with the specimen itself, and what the identified damper "
                "is off by. With a real damper, whose force may bend where its tests end, only wider tests would tell."
            ),
            *to_look_at(demo.of_building.findings),
            Table(
                (
                    "case",
                    "first floor",
                    "roof",
                    "largest drift",
                    "largest acceleration",
                    "damper force",
                    "first drift",
                    "first floor, specimen",
                    "off by",
                ),
                rows,
                ("", "mm", "mm", "mm", "m/s²", "N", "% of bare", "mm", "%"),
                caption="Peaks; displacements relative to the ground, accelerations absolute.",
                digits=4,
            ),
            FigureBlock(
                building_response(bare.time, first),
                "Displacement of the first floor, and the largest sample of each case; the peaks of the table lie between "
                "samples, too.",
            ),
        ],
    )
