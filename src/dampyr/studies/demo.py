"""The whole chain on a simulated rig: tests, records on disk, identification, validation, and a building in an earthquake.

The specimen (`specimen`) follows a fit to the records of the published campaign, F0 + k x + c v + Fy tanh((v + s x)/v0). The
model that is identified is another one, so the demonstration shows a misfit as a real damper would.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr import ground_motions, structures
from dampyr.identification import Fit, Score, fit, prediction, score
from dampyr.models import Damper, Interpolation, Law
from dampyr.records import Record, read_campaign, write

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]

MODEL = "dahl + hyperbolic_tangent + spring + delay"
FIXED = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}  # one dashpot, that of dahl; no shift
LAWS = {"dahl.rho": "constant", "delay.tau": "constant"}  # one pre-sliding path, and one lag: the rig's
VOLTAGES = (0.0, 0.8712, 1.98, 3.212)
SINES = ((24e-3, 0.85), (18e-3, 0.97), (13e-3, 1.1), (8e-3, 1.2))  # peak to peak m, Hz
HELD_OUT = (
    (0.0, 15e-3, 1.0),
    (0.8712, 20e-3, 0.7),
    (1.4, 14e-3, 0.9),
    (1.98, 10e-3, 1.05),
    (2.6, 12e-3, 0.8),
    (3.212, 9e-3, 1.0),
)
DT, REST, LENGTH = 0.01, 1.0, 9.0
COUNT, FORCE_STEP, NOISE, LAG, SEED = 5e-6, 0.187, 1.5, 0.006, 2020


def specimen() -> Damper:
    """The simulated damper: parameters over the voltage as fitted to the published campaign (mm, s, N there; SI here)."""
    rows = np.array(
        [  # F0 N, k N/m, c N s/m, Fy N, s 1/s, v0 m/s
            [134.0, 910.0, 770.0, 58.0, 0.36, 0.0040],
            [131.0, 1180.0, 1520.0, 202.0, 0.13, 0.0032],
            [124.0, 1390.0, 2100.0, 409.0, 0.46, 0.0086],
            [114.0, 810.0, 3350.0, 660.0, 0.61, 0.0118],
        ]
    )
    tanh = [f"hyperbolic_tangent.{key}" for key in ("c", "ft", "s", "v0")]
    names = ["offset.f0", "spring.k0", *tanh]
    laws: dict[str, Law | float] = {
        name: Interpolation(VOLTAGES, tuple(column)) for name, column in zip(names, rows.T, strict=True)
    }
    return Damper("hyperbolic_tangent + spring + offset", laws, provenance={"source": "simulated specimen of the demo"})


def simulated_test(
    damper: Damper, voltage: float, peak_to_peak: float, frequency: float, name: str, rng: np.random.Generator
) -> Record:
    """One test on a simulated rig: rest, a sine that grows over one cycle, and what the instruments make of it.

    The encoder counts in 5 um, the force channel is 6 ms late, has noise of 1.5 N, steps of 0.187 N and a zero that moves a
    few newton from test to test.
    """
    fine = 10
    t = np.arange(round(LENGTH / DT) * fine + 1) * DT / fine
    growth = np.clip((t - REST) * frequency, 0.0, 1.0)
    phase = 2 * np.pi * frequency * np.maximum(t - REST, 0.0)
    x = 0.5 * peak_to_peak * growth**2 * (3 - 2 * growth) * (np.sin(phase) + 0.04 * np.sin(3 * phase))
    v = np.gradient(x, t)
    force = damper.force(t, x, voltage=voltage, velocity=v)
    force = np.interp(t - LAG, t, force)[::fine]
    force = force + rng.normal(0.0, 5.0) + rng.normal(0.0, NOISE, force.size)
    counts = np.round(x[::fine] / COUNT) * COUNT
    return Record(
        time=t[::fine],
        displacement=counts,
        force=np.round(force / FORCE_STEP) * FORCE_STEP,
        voltage=voltage,
        name=name,
        provenance={"source": "simulated by dampyr demo", "complete": "yes"},
    )


@dataclass(frozen=True)
class Demo:
    """What the demonstration made: records, the fit, its scores on tests it never saw, and the building's responses."""

    folder: Path
    fitted: list[Record]
    held_out: list[Record]
    fit: Fit
    scores: dict[str, Score]
    predictions: dict[str, Array]
    responses: dict[str, Any]

    @property
    def card(self) -> Path:
        """The file of the identified damper."""
        return self.folder / "damper.toml"

    def summary(self) -> dict[str, Any]:
        """The figures of the page as plain numbers, SI."""
        return {
            "model": MODEL,
            "converged": self.fit.converged,
            "reason": self.fit.reason,
            "parameters": self.fit.parameters,
            "stderr": self.fit.stderr,
            "within_records_only": list(self.fit.within_records),
            "l1_fitted": {name: s.l1 for name, s in self.fit.scores.items()},
            "l1_held_out": {name: s.l1 for name, s in self.scores.items()},
            "peak_displacement_m": {name: r.peak_displacement for name, r in self.responses.items()},
            "card": self.card,
            "records": self.folder / "records",
        }


def demo(folder: str | Path, progress: Progress = lambda stage, done: None) -> Demo:
    """Run the chain and leave records, the card and ``report.html`` in ``folder``."""
    out = Path(folder)
    fitted, held_out = _measured(out / "records", progress)
    progress("identifying", 0.0)
    fit_result = fit(
        MODEL,
        fitted,
        LAWS,
        FIXED,
        bandwidth=15.0,
        progress=lambda k, _: progress("identifying", min(k / 40, 1.0)),
    )
    progress("identifying", 1.0)
    if fit_result.damper is None:
        raise RuntimeError(f"the demonstration's fit gave no damper: {fit_result.reason}")
    fit_result.damper.save(out / "damper.toml")
    scores, predictions = {}, {}
    for k, record in enumerate(held_out):
        progress("validating on tests it never saw", k / len(held_out))
        scores[record.name] = score(fit_result.damper, record)
        predictions[record.name] = prediction(fit_result.damper, record)
    progress("validating on tests it never saw", 1.0)
    result = Demo(out, fitted, held_out, fit_result, scores, predictions, _building(fit_result.damper, progress))
    progress("writing the report", 0.0)
    from dampyr.studies.demo_page import write_report

    write_report(result, out / "report.html")
    progress("writing the report", 1.0)
    return result


def _measured(folder: Path, progress: Progress) -> tuple[list[Record], list[Record]]:
    """Run the tests, put them on disk, and read them back from there."""
    damper, rng = specimen(), np.random.default_rng(SEED)
    tests = [(u, *sine, False) for u in VOLTAGES for sine in SINES] + [(*each, True) for each in HELD_OUT]
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.h5"):
        old.unlink()
    for k, (voltage, stroke, frequency, unseen) in enumerate(tests):
        progress("testing on the simulated rig", k / len(tests))
        name = f"{'unseen' if unseen else 'test'}-{voltage:g}V-{1e3 * stroke:g}mm-{frequency:g}Hz"
        record = simulated_test(damper, voltage, stroke, frequency, name, rng)
        if unseen:
            record = record.replace(note="held out of the fit", role="validation")
        write(record, folder / f"{name}.h5")
    progress("testing on the simulated rig", 1.0)
    return read_campaign(folder, role="fit"), read_campaign(folder, role="validation")


def _building(damper: Damper, progress: Progress) -> dict[str, Any]:
    """Three cases of the chapter-5 building under El Centro; the rig's own delay stays at the rig."""
    alone = damper.without("delay")
    building, motion = structures.two_storey(), ground_motions.el_centro()
    cases: dict[str, dict[str, Any]] = {
        "no damper": {},
        "damper at 0 V": {"dampers": {1: alone}, "voltage": 0.0},
        "damper at 3.212 V": {"dampers": {1: alone}, "voltage": 3.212},
    }
    responses = {}
    for k, (name, options) in enumerate(cases.items()):
        progress("shaking the building", k / len(cases))
        responses[name] = structures.respond(building, motion, **options)
    progress("shaking the building", 1.0)
    return responses
