r"""Four magnetorheological dampers in the frame of the hybrid benchmark (Quiroz 2022), off, on and under control.

A thesis of UTFSM; the numbers are those of a replica from its published program, github.com/DanielMaurelE/vRTHS_AMBC_MRdamper
(commit 08753ff). The frame is `vrths_2020`'s, El Centro and Kobe at half of the recorded acceleration. Four modified Bouc-Wen
dampers stand in parallel in storey 1, with the current i in A, N, mm and s:

.. math:: \alpha = -38.152 i^2 + 41.508 i + 15.221, \quad \gamma = \beta = 1.894\, e^{-3.656 i}, \quad
          c_0 = 7.626 i + 0.925, \quad c_1 = 78.337 i + 9.867

:math:`k_0` = 1.5e-4, :math:`k_1` = 1.239, A = 300, n = 2. "on" is 1 A. Its clipped-optimal control has a Kalman filter on three
accelerations and the force (`dampyr.studies._quiroz_law`) and decides 4,096 times a second; 4,100 times here, as the motions'
samples have it. The current follows at once.

The memory z of the source's model goes on where the current jumps; dampyr's is a share of its limit, and jumps with that. Peaks
of acceleration under control differ for that reason, and one displacement: a Runge-Kutta on the source's own equations with the
same controller meets them within 1 % (tests/studies/test_quiroz_2022.py).
"""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path

from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper, Interpolation
from dampyr.models.parts import modified_bouc_wen
from dampyr.structures import Response, Sensor, respond
from dampyr.studies import vrths_2020
from dampyr.studies._compared_value import AlternativeValue, ComparedValue, ComparisonTolerance, judge
from dampyr.studies._quiroz_law import QuirozLaw
from dampyr.studies._study_run import Progress, StudyRun, write

COUNT, INTENSITY = 4, 0.5
CURRENTS = {"none": None, "off": 0.0, "on": 1.0}  # A
OPTIMAL = "clipped-optimal"
FLOORS = {  # El Centro, case 1: peaks of displacement, mm, of absolute acceleration, m/s2, and of the force of all four, N
    "none": ((4.877, 7.886, 9.710), (2.639, 3.950, 5.289), None),
    "off": ((4.042, 6.550, 8.067), (2.494, 3.559, 4.358), 827.0),
    "on": ((1.039, 1.793, 2.333), (1.588, 2.022, 2.251), 4656.0),
    OPTIMAL: ((1.145, 1.942, 2.483), (1.740, 1.880, 2.125), 4700.0),
}
ROOFS = {  # mm, in the order of none, off, on and clipped-optimal
    ("Kobe", 1): (14.734, 14.109, 8.563, 8.433),
    ("El Centro", 2): (10.020, 9.135, 2.662, 2.773),
    ("El Centro", 3): (13.491, 11.158, 4.027, 4.048),
}
TOLERANCE = ComparisonTolerance(relative=0.02)
RATE = 4096.0  # 1/s, of the decisions
APART = {("El Centro", 1): (1.744, 1.888, 2.146), ("El Centro", 2): (2.777,)}  # m/s2 of the floors, and mm of the roof
WORDS = "that of a Runge-Kutta on the source's own equations, whose memory goes on where the current jumps and ours does not"
LEFT_OUT = "the share of the time at 1 A, which a switch at 4,096 Hz makes a matter of its last digit"


def four_dampers(current: float) -> Damper:
    """All four dampers as one, at a current in A."""
    gamma = 1e6 * 1.89407553 * math.exp(-3.65610854 * current)
    printed = modified_bouc_wen.PrintedModifiedBoucWen(
        c0=COUNT * 1e3 * (7.62596402 * current + 0.924911328),
        c1=COUNT * 1e3 * (78.3366934 * current + 9.86712839),
        k0=COUNT * 1e3 * 1.50132794e-4,
        k1=COUNT * 1e3 * 1.23879769,
        alpha=COUNT * 1e3 * (-38.1520043 * current**2 + 41.5084056 * current + 15.2210961),
        A=300.0,
        beta=gamma,
        gamma=gamma,
        n=2.0,
    )
    return Damper("modified_bouc_wen", asdict(modified_bouc_wen.from_printed(printed)), input="none")


def switched_dampers() -> Damper:
    """All four over the current, for control that switches between 0 and 1 A: right at these two alone."""
    off, on = (four_dampers(current).all_laws for current in (0.0, 1.0))
    ends = {name: (float(off[name](0.0)), float(on[name](0.0))) for name in off}
    return Damper(
        "modified_bouc_wen", {name: Interpolation((0.0, 1.0), pair) for name, pair in ends.items()}, input="A"
    )


def control(motion: GroundMotion) -> QuirozLaw:
    """The law, which decides at whole parts of the motion's samples; what it measures is one sample late."""
    late = {measure: Sensor(delay=1) for measure in ("accelerations", "force")}
    return QuirozLaw(0.0, 1.0, motion.dt / round(motion.dt * RATE), sensors=late)


def reproduce(data: Path | None = None, out: Path | None = None, progress: Progress | None = None) -> StudyRun:
    """Run all cases; ``data`` is the folder of the two motions of `vrths_2020`.

    MissingData where the motions are not there.
    """
    cases = [("El Centro", 1), *ROOFS]
    motions = {name: vrths_2020.motion(name, data, INTENSITY) for name in ("El Centro", "Kobe")}
    compared: list[ComparedValue] = []
    for k, (name, case) in enumerate(cases):
        if progress is not None:
            progress(f"{name}, case {case}", k / len(cases))
        building = vrths_2020.structure(case)
        for column, kind in enumerate((*CURRENTS, OPTIMAL)):
            if kind == OPTIMAL:
                response = respond(building, motions[name], {1: switched_dampers()}, current=control(motions[name]))
            else:
                current = CURRENTS[kind]
                response = respond(building, motions[name], None if current is None else {1: four_dampers(current)})
            where = f"{name}, case {case}, {kind}"
            apart = APART.get((name, case), ()) if kind == OPTIMAL else ()
            if (name, case) in ROOFS:
                roof = 1e3 * float(response.peak_displacement[-1])
                candidates = [AlternativeValue(value, WORDS) for value in apart]
                compared.append(judge(where, "roof", ROOFS[name, case][column], roof, "mm", TOLERANCE, candidates))
            else:
                compared += _of_floors(where, kind, response, apart)
    source = "a replica from github.com/DanielMaurelE/vRTHS_AMBC_MRdamper (commit 08753ff)"
    study = StudyRun("quiroz_2022", "Quiroz (2022)", source, tuple(compared), (LEFT_OUT,))
    return write(study, out)


def _of_floors(where: str, kind: str, response: Response, apart: tuple[float, ...]) -> list[ComparedValue]:
    displacements, accelerations, force = FLOORS[kind]
    values = [
        judge(
            where, f"displacement, floor {k + 1}", theirs, 1e3 * float(response.peak_displacement[k]), "mm", TOLERANCE
        )
        for k, theirs in enumerate(displacements)
    ]
    values += [
        judge(
            where,
            f"acceleration, floor {k + 1}",
            theirs,
            float(response.peak_acceleration[k]),
            "m/s²",
            TOLERANCE,
            [AlternativeValue(value, WORDS) for value in apart[k : k + 1]],
        )
        for k, theirs in enumerate(accelerations)
    ]
    if force is not None:
        values.append(judge(where, "force", force, float(response.peak_force[0]), "N", TOLERANCE))
    return values
