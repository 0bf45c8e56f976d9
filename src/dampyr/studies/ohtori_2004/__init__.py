"""The 20-storey benchmark building of Ohtori et al. (2004): its elastic frame, from two tables.

Y. Ohtori, R. E. Christenson, B. F. Spencer, S. J. Dyke, "Benchmark control problems for seismically excited nonlinear
buildings", Journal of Engineering Mechanics 130 (2004). Two frames of 138 nodes and 242 elements each, pinned below two
basement levels and held horizontally at the ground; the floors are rigid horizontally; Rayleigh damping of 2 % in modes 1
and 5. The tables were made from the numbers of the benchmark's published program.

`reproduce` sets the benchmark's elastic numbers beside ours. `structure` is the building on its 20 floors, by modes.
`STOREY_HEIGHTS` [m] and `FLOOR_MASSES` [kg] are those with which the benchmark evaluates drift ratios and the base shear. A
response's own base shear is that of all that moves, the basement's floor below the ground level included; the benchmark's is
``FLOOR_MASSES @ response.acceleration``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dampyr.studies.ohtori_2004.frame import FLOOR_MASSES, STOREY_HEIGHTS, structure

if TYPE_CHECKING:
    from dampyr.studies._study_run import Progress, StudyRun

__all__ = ["FLOOR_MASSES", "STOREY_HEIGHTS", "STRUCTURES", "reproduce", "structure"]


def reproduce(data: Path | None = None, out: Path | None = None, progress: Progress | None = None) -> StudyRun:
    """The frequencies and the elastic El Centro row of the benchmark beside ours.

    The benchmark's own record is not public; ``ground-motions/elcentro.dat`` in ``data`` is close enough to it. What needs a
    record or a member that is not there is among what was left out.
    """
    from dampyr.studies.ohtori_2004.elastic_study import run

    return run(data, out, progress)


STRUCTURES = {"ohtori_2004": structure}
"""The building, by its name on the command line."""
