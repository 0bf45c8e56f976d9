"""The virtual real-time hybrid simulation benchmark of Silva et al. (2020), with three compensators and over random plants.

C. E. Silva, D. Gomez, A. Maghareh, S. J. Dyke, B. F. Spencer, "Benchmark control problem for real-time hybrid simulation",
Mechanical Systems and Signal Processing 135 (2020) 106381. The first floor's spring of a frame of three floors is a specimen in
an actuator, the rest is computed; four buildings, two earthquakes, nine criteria. The numbers compared with are those of a
replica from the benchmark's published files, because the table in the paper could not be read.

`structure` is one of the four buildings, `motion` an earthquake of the benchmark, `reproduce` runs all of it.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from dampyr.studies.vrths_2020.benchmark import CASES, INTENSITY, MOTIONS, motion, structure

if TYPE_CHECKING:
    from dampyr.studies.vrths_2020.vrths_study import Progress, VrthsStudy

__all__ = ["CASES", "INTENSITY", "MOTIONS", "STRUCTURES", "motion", "reproduce", "structure"]

STRUCTURES = {f"vrths_2020_case_{case}": partial(structure, case) for case in CASES}
"""The four buildings, by their names on the command line."""


def reproduce(
    data: str | Path | None = None,
    out: str | Path | None = None,
    plants: int = 1000,
    progress: Progress | None = None,
) -> VrthsStudy:
    """Run the benchmark.

    Parameters
    ----------
    data
        The folder of the two motions, as in `motion`.
    out
        Where to write ``vrths_2020.html`` and ``vrths_2020.json``; None writes nothing.
    plants
        How many random plants each case is run on with dampyr's compensator; 0 leaves them out.
    progress
        Called with a stage and how much of it is done, 0 to 1.

    Raises
    ------
    MissingData
        The motions are not there.
    """
    from dampyr.studies.vrths_2020.vrths_study import run, write

    study = run(data, plants, progress or (lambda stage, done: None))
    return study if out is None else write(study, Path(out))
