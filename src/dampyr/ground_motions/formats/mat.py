"""MATLAB .mat (version 5) with one matrix of two columns or two rows, time [s] and acceleration, such as
ElCentroData.mat."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.samples import motion_of, step_of

SUFFIXES = (".mat",)


def read(path: Path, units: str | None = None, dt: float | None = None) -> GroundMotion:
    """The ground motion of the one (n, 2) or (2, n) matrix of a file; its unit is declared, such as ``units="g"``."""
    from scipy.io import loadmat

    try:
        content = loadmat(path)
    except (ValueError, NotImplementedError, OSError, TypeError) as problem:
        raise FileError(path, f"is not a MATLAB file of version 5 ({problem}); save it again with -v7") from None
    tables = {k: v for k, v in content.items() if isinstance(v, np.ndarray) and v.ndim == 2 and 2 in v.shape}
    if len(tables) != 1:
        held = ", ".join(sorted(k for k in content if not k.startswith("__"))) or "nothing"
        raise FileError(
            path, f"holds {held}; it must hold one matrix with the two columns (or rows) time and acceleration"
        )
    if units is None:
        raise FileError(path, "no unit is known for the acceleration; declare it, such as units='g'")
    name, table = next(iter(tables.items()))
    time, values = np.asarray(table if table.shape[1] != 2 else table.T, dtype=float)
    return motion_of(path, values, step_of(path, time, dt), units, source=f"{path.name}, variable {name}")
