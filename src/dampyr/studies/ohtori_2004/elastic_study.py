"""The elastic El Centro row of the benchmark beside ours; see `dampyr.studies.ohtori_2004.reproduce`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dampyr.errors import MissingData
from dampyr.ground_motions import GroundMotion, read, resampled
from dampyr.records.datasets import data_root
from dampyr.structures import respond
from dampyr.studies._compared_value import ComparedValue, ComparisonTolerance, judge, unchecked
from dampyr.studies._study_run import Progress, StudyRun, write
from dampyr.studies.ohtori_2004.frame import FLOOR_MASSES, STOREY_HEIGHTS, structure

FREQUENCIES = (0.2613, 0.7526, 1.299, 1.827, 2.398)  # Hz
EL_CENTRO = {
    "drift ratio": 0.0070835,
    "base shear": 7.37645e6,
    "largest displacement": 0.304389,
    "largest speed": 0.915664,
}
ACCELERATION = 5.33923  # m/s2
HACHINOHE = {
    "drift ratio": 0.0064111,
    "base shear": 6.35682e6,
    "largest displacement": 0.347946,
    "largest speed": 0.902439,
}
UNITS = {"drift ratio": "", "base shear": "N", "largest displacement": "m", "largest speed": "m/s"}
TOLERANCE = ComparisonTolerance(relative=0.005)
END, STEP = 100.0, 0.01  # s
FILE = Path("ground-motions") / "elcentro.dat"
SPEED = "of this record the speed is 0.9238 m/s in the limit of the step, by Newmark's rule and by ours"
OTHER = "the record of the benchmark is not here, and no other is close to it"
MOTION = f"the motion {FILE.name} is not here; give the folder that holds {FILE.parent} as data"


def run(data: Path | None, out: Path | None, progress: Progress | None) -> StudyRun:
    """See `dampyr.studies.ohtori_2004.reproduce`."""
    tell = progress or (lambda stage, done: None)
    building = structure()
    tell("frequencies", 0.0)
    compared = [
        judge("modes", f"frequency {k + 1}", theirs, float(ours), "Hz", ComparisonTolerance(relative=2e-4))
        for k, (theirs, ours) in enumerate(zip(FREQUENCIES, building.frequencies[:5], strict=True))
    ]
    left_out: list[str] = [
        f"Hachinohe: {OTHER}",
        "the cases with yielding members: storeys that yield are not there yet",
    ]
    try:
        motion = _motion(data)
    except MissingData as problem:
        left_out.append(str(problem))
        compared += [unchecked("El Centro", name, value, UNITS[name], MOTION) for name, value in EL_CENTRO.items()]
    else:
        tell("El Centro", 0.2)
        compared += _el_centro(motion)
    compared += [unchecked("Hachinohe", name, value, UNITS[name], OTHER) for name, value in HACHINOHE.items()]
    source = "Ohtori et al. (2004), Journal of Engineering Mechanics 130; numbers of the benchmark's published program"
    study = StudyRun("ohtori_2004", "Ohtori et al. (2004), elastic", source, tuple(compared), tuple(left_out))
    return write(study, out)


def _motion(data: Path | None) -> GroundMotion:
    folder = data_root() if data is None else data
    if not (folder / FILE).is_file():
        raise MissingData(f"El Centro: there is no {folder / FILE}; {MOTION}")
    return resampled(read(folder / FILE, units="g"), STEP, "linear")


def _el_centro(motion: GroundMotion) -> list[ComparedValue]:
    response = respond(structure(), motion, after=END - float(motion.time[-1]))
    ours = {
        "drift ratio": float(np.max(response.peak_drift / np.array(STOREY_HEIGHTS))),
        "base shear": float(np.max(np.abs(np.array(FLOOR_MASSES) @ response.acceleration))),
        "largest displacement": float(np.max(response.peak_displacement)),
        "largest speed": float(np.max(np.abs(response.velocity))),
    }
    values = [
        judge(
            "El Centro",
            name,
            EL_CENTRO[name],
            value,
            UNITS[name],
            TOLERANCE,
            otherwise=SPEED * (name == "largest speed"),
        )
        for name, value in ours.items()
    ]
    peak = float(np.max(response.peak_acceleration))
    return [*values, judge("El Centro", "largest acceleration", ACCELERATION, peak, "m/s²", TOLERANCE)]
