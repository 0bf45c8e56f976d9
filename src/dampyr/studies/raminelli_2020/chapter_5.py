"""Chapter 5: the two-storey building (5.1)-(5.6) under El Centro with the published damper in its first storey."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion, el_centro, read
from dampyr.models import Damper
from dampyr.show.figures.building import building_response
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.pages.blocks import Block, FigureBlock, Text
from dampyr.show.table import Cell, Table
from dampyr.structures import Response, respond, state_space, two_storey
from dampyr.studies._compared_value import (
    ComparedValue,
    ComparisonTolerance,
    Erratum,
    claim,
    judge,
    unchecked,
)
from dampyr.studies._study_run import compared_table
from dampyr.studies.raminelli_2020.chapter_2 import PICTURE
from dampyr.studies.raminelli_2020.cubics import published_damper
from dampyr.studies.raminelli_2020.published import Published
from dampyr.studies.raminelli_2020.study_part import StudyPart

MILLIONTH = ComparisonTolerance(relative=1e-6)
MOTION_FILE = "ElCentroData.mat"
PERCENT = ComparisonTolerance(relative=0.01)
ALSO = (1.98, 3.21)  # V: the two highest voltages of the calibration, the last rounded down so that it stays inside
CASE = ("case 1, no damper", "case 2, 0 V", "case 3")


def chapter_5(published: Published, data: Path | None = None) -> StudyPart:
    """Figs. 5.1 and 5.4, the peaks and the percentages."""
    motion, damper = el_centro(), published_damper(published)
    cases, notes = run_cases(published, motion, damper)
    names = list(cases)
    ours = [1e3 * float(cases[name].peak_displacement[0]) for name in names[:3]]
    slip = unit_slip(published, motion, damper, ours[0])
    judged = [
        *laboratory_motion(motion, data),
        unchecked("Figure 5.4", "the curves", None, "", PICTURE),
        *peaks(published, names, ours, slip),
        *reductions(published, ours),
        ranking(ours),
    ]
    errata = [_ground(), _output_sign(cases[names[1]])]
    return StudyPart(
        "Chapter 5: the building in the earthquake",
        judged,
        _blocks(published, motion, cases, slip, notes, judged),
        errata,
    )


def laboratory_motion(motion: GroundMotion, data: Path | None) -> list[ComparedValue]:
    """Figure 5.1 is a picture; the laboratory's own file of the motion, where it lies beside the data, is the built-in one."""
    candidates = (
        [folder / MOTION_FILE for folder in (data, data.parent, data.parent / "ground-motions")] if data else []
    )
    motion_path = next((path for path in candidates if path.is_file()), None)
    curve = unchecked("Figure 5.1", "the curve", None, "", PICTURE)
    if motion_path is None:
        missing = f"the laboratory's {MOTION_FILE} is not beside the data"
        return [curve, unchecked("Figure 5.1", "the motion's samples", None, "", missing)]
    theirs = np.trim_zeros(np.asarray(read(motion_path, units="g").acceleration))
    ours = np.trim_zeros(np.asarray(motion.acceleration))
    same = theirs.shape == ours.shape
    reason = f"{theirs.size} samples in {MOTION_FILE}, {ours.size} in the built-in motion, zeros at the ends aside"
    peaks = [float(np.abs(values).max()) for values in (theirs, ours)]
    if same:
        reason += f"; they differ by {float(np.max(np.abs(theirs - ours))):.1g} m/s² at most"
    peak = judge("Figure 5.1", f"peak acceleration (published: {MOTION_FILE})", peaks[0], peaks[1], "m/s²", MILLIONTH)
    alike = same and bool(np.allclose(theirs, ours, rtol=1e-6, atol=1e-6))
    return [curve, peak, claim("Figure 5.1", "the motion's samples", MOTION_FILE, motion.name, alike, reason)]


def run_cases(published: Published, motion: GroundMotion, damper: Damper) -> tuple[dict[str, Response], list[str]]:
    """The three cases, and two more voltages inside the calibration; the warnings that came with them."""
    high = float(published.highest_voltage)
    voltages: dict[str, float | None] = {CASE[0]: None, CASE[1]: 0.0, f"{CASE[2]}, {high:g} V": high}
    voltages |= {f"{v:g} V": v for v in ALSO}
    responses, notes = {}, []
    for name, voltage in voltages.items():
        responses[name], warned = _shake(motion, damper, voltage)
        notes += [f"{name}: {warning}" for warning in warned]
    return responses, notes


def _shake(motion: GroundMotion, damper: Damper, voltage: float | None) -> tuple[Response, list[str]]:
    """One response; warnings of dampyr's own become notes of the page."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DampyrWarning)
        dampers = None if voltage is None else {1: damper}
        response = respond(two_storey(), motion, dampers, voltage, allow_extrapolation=True)
    return response, list(dict.fromkeys(str(w.message) for w in caught))


def slipped(damper: Damper) -> Damper:
    """The damper of mm, N and s fed a velocity in m/s: kx and rho come out a thousand times too small, kw as it is."""
    laws: dict[str, Any] = {}
    for name, law in damper.all_laws.items():
        factor = 1.0 if name == "dahl.kw" else 1e-3
        laws[name] = law.with_coefficients(factor * np.array(law.coefficients))
    return replace(
        damper, laws=laws, ranges={}, provenance={"source": "the published damper, fed a velocity in m/s for mm/s"}
    )


def unit_slip(published: Published, motion: GroundMotion, damper: Damper, bare: float) -> Mapping[str, float]:
    """The hypothesis: the motion scaled to give the printed peak without damper, and the damper fed m/s; peaks in mm."""
    scale = float(published.peaks[0]) / bare
    with_slip = slipped(damper)
    high = float(published.highest_voltage)
    two, three = (1e3 * float(_shake(motion.scaled(scale), with_slip, v)[0].peak_displacement[0]) for v in (0.0, high))
    return {"scale": scale, "case 2": two, "case 3": three}


def peaks(published: Published, names: list[str], ours: list[float], slip: Mapping[str, float]) -> list[ComparedValue]:
    """The three printed peaks of the first floor."""
    reasons = [
        f"the printed peak is {slip['scale']:.4f} times what (5.1)-(5.2) give under El Centro; the building "
        "alone is linear, so a motion "
        "scaled by as much would give it, and the text names no scale",
        *(_describe_slip(slip, published.peaks[k], f"case {k + 1}") for k in (1, 2)),
    ]
    judged = []
    for name, theirs, value, why in zip(names, published.peaks, ours, reasons):
        judged.append(
            judge("Figure 5.4", f"peak of the first floor, {name}", theirs, value, "mm", PERCENT, otherwise=why)
        )
    return [*judged, _slip_verdict(published, slip)]


def _describe_slip(slip: Mapping[str, float], printed: float, case: str) -> str:
    deviation = slip[case] / printed - 1
    near = "close to" if PERCENT.allows(printed, slip[case]) else "not"
    return (
        f"with the motion scaled {slip['scale']:.4f} times and the damper fed m/s for mm/s it would be {slip[case]:.4f} mm, "
        f"{near} the printed value ({100 * deviation:+.2g} %)"
    )


def _slip_verdict(published: Published, slip: Mapping[str, float]) -> ComparedValue:
    """How far the hypothesis of a unit slip goes."""
    fits = [PERCENT.allows(published.peaks[k], slip[f"case {k + 1}"]) for k in (1, 2)]
    outcome = {2: "explains both", 1: "likely, not proven", 0: "not supported"}[sum(fits)]
    which = " and ".join(f"case {k + 2}" for k, fit in enumerate(fits) if fit) or "neither case"
    reason = f"a hypothesis with one free number, the scale {slip['scale']:.4f}, taken from case 1; it meets {which} within 1 %"
    ours = f"{slip['case 2']:.4f} and {slip['case 3']:.4f} mm"
    theirs = f"{published.peaks[1].text} and {published.peaks[2].text} mm"
    return claim(
        "Figure 5.4", f"a unit slip (m/s for mm/s) and a scaled motion: {outcome}", theirs, ours, all(fits), reason
    )


def reductions(published: Published, ours: list[float]) -> list[ComparedValue]:
    """The two printed percentages, from the printed peaks; and from our peaks in the reason."""
    bare, judged = float(published.peaks[0]), []
    for k, printed in enumerate(published.reductions, start=1):
        theirs = 100 * (bare - float(published.peaks[k])) / bare
        of_ours = 100 * (ours[0] - ours[k]) / ours[0]
        why = (
            f"({published.peaks[0]:.4f} − {published.peaks[k]:.4f})/{published.peaks[0]:.4f} is {theirs:.4g} %; a reduction by "
            f"{printed:g} % would be a peak of {bare * (1 - printed / 100):.4f} mm; our own peaks give {of_ours:.3g} %"
        )
        quantity = f"reduction in case {k + 1}, from the printed peaks"
        judged.append(judge("Section 5.2", quantity, printed, theirs, "%", otherwise=why))
    return judged


def ranking(ours: list[float]) -> ComparedValue:
    """“The best case is when the MR damper is active with voltage”."""
    best = int(np.argmin(ours))
    reason = "our peaks of the first floor: " + ", ".join(f"{value:.4f} mm" for value in ours)
    return claim("Section 5.2", "the case with the smallest peak", "case 3", f"case {best + 1}", best == 2, reason)


def _ground() -> Erratum:
    return Erratum(
        "(5.1)",
        "“x_g is the acceleration of the ground”",
        "x_g is its displacement, d²x_g/dt² its acceleration",
        "(5.1) multiplies M by the second derivative of x_g, and (5.3) has it as the input",
    )


def _output_sign(response: Response) -> Erratum:
    """(5.4) with both signs of D_y, against the absolute acceleration of the response."""
    space = state_space(two_storey(), 1)
    state = np.vstack((response.displacement, response.velocity))
    size = float(np.max(np.abs(response.acceleration)))
    errors = {
        sign: float(np.max(np.abs(space.C @ state + sign * space.D @ response.force - response.acceleration))) / size
        for sign in (1.0, -1.0)
    }
    better = "+" if errors[1.0] < errors[-1.0] else "−"
    return Erratum(
        "(5.6)",
        "D_y = −M⁻¹Λ",
        f"D_y = {better}M⁻¹Λ",
        f"given (5.1) and B_s of (5.5); in case 2 the output with + is {100 * errors[1.0]:.2g} % of the peak from "
        "the floors' absolute "
        f"accelerations, with the printed − {100 * errors[-1.0]:.3g} %",
    )


def _stroke(response: Response) -> float:
    """The largest stroke of the dampers, mm; 0 without any."""
    return 1e3 * float(np.abs(response.stroke).max()) if response.stroke.size else 0.0


def _blocks(
    published: Published,
    motion: GroundMotion,
    cases: Mapping[str, Response],
    slip: Mapping[str, float],
    notes: list[str],
    judged: list[ComparedValue],
) -> list[Block]:
    rows: list[list[Cell]] = [
        [
            name,
            *(1e3 * r.peak_displacement),
            1e3 * float(r.peak_drift[1]),
            *r.peak_acceleration,
            _max_force(r),
            r.scheme,
        ]
        for name, r in cases.items()
    ]
    heads = ("case", "floor 1", "floor 2", "drift 2", "acceleration 1", "acceleration 2", "force", "scheme")
    units = ("", "mm", "mm", "mm", "m/s²", "m/s²", "N", "")
    names = list(cases)[:3]
    shown = {name: cases[name].displacement[0] for name in names}
    text = [
        f"The hypothesis: the motion scaled {slip['scale']:.4f} times, so that case 1 meets the printed peak, "
        "and the damper fed m/s "
        f"for mm/s. It gives {slip['case 2']:.4f} mm in case 2 and {slip['case 3']:.4f} mm in case 3."
    ]
    widest = 0.5 * max(row.displacement for row in published.rows)
    wide = [f"{name} ({_stroke(r):.3g} mm)" for name, r in cases.items() if _stroke(r) > widest]
    text.append(
        f"The damper was tested up to {widest:.4g} mm to either side; "
        + (f"beyond that goes {', '.join(wide)}." if wide else "no case goes beyond.")
    )
    if notes:
        text.append("Outside the calibration: " + "; ".join(notes) + ".")
    return [
        FigureBlock(ground_motion(motion.time, motion.acceleration), f"Figure 5.1 again: {motion.source}."),
        FigureBlock(
            building_response(cases[names[0]].time, shown), "Figure 5.4 again: the first floor in the three cases."
        ),
        Table(heads, rows, units, caption="Peaks, inside the step too; accelerations are absolute.", digits=6),
        Text("\n\n".join(text)),
        compared_table(judged, digits=7),
    ]


def _max_force(response: Response) -> float | None:
    return float(response.peak_force.max()) if response.peak_force.size else None
