"""What the benchmark gives: four buildings from their files, and two earthquakes from theirs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dampyr.errors import FileError, InputError, MissingData
from dampyr.ground_motions import GroundMotion
from dampyr.records.datasets import data_root
from dampyr.structures import Building, load

SOURCE = "https://github.com/DanielMaurelE/vRTHS_AMBC_MRdamper"
CASES = (1, 2, 3, 4)
"""The buildings, by number."""
MOTIONS = {
    "El Centro": ("ElCentroAccelNoScaling.mat", "ElCentroAccel"),
    "Kobe": ("KobeAccelNoScaling.mat", "KobeAccel"),
}
"""The earthquakes: of each the file and the variable in it."""
INTENSITY = 0.4
"""The share of the recorded acceleration that the benchmark applies."""


def structure(case: int) -> Building:
    """The building of a case, 1 to 4, from its file; :class:`~dampyr.errors.InputError` for another."""
    if case not in CASES or isinstance(case, bool):
        raise InputError(f"case {case!r} is not one of the benchmark's; choose from 1 to 4")
    return load(Path(__file__).parent / f"case_{case}.toml")


def motion(name: str = "El Centro", data: str | Path | None = None, intensity: float = INTENSITY) -> GroundMotion:
    """An earthquake of the benchmark, "El Centro" or "Kobe", times ``intensity``.

    ``data`` is the folder of its two .mat files; by default ``vrths_2020`` among the data (``DAMPYR_DATA``). MissingData says
    where they are published.
    """
    from scipy.io import loadmat

    if name not in MOTIONS:
        raise InputError(f"{name!r} is not a motion of the benchmark; choose from {', '.join(MOTIONS)}")
    file, variable = MOTIONS[name]
    folder = data_root() / "vrths_2020" if data is None else Path(data)
    if not (folder / file).is_file():
        raise MissingData(f"{file} is not in {folder}; get it from {SOURCE} and pass its folder, data=...")
    try:
        table = np.asarray(loadmat(folder / file)[variable], dtype=float)
    except (ValueError, NotImplementedError, TypeError, KeyError, OSError) as problem:
        raise FileError(folder / file, f"has no motion {variable} ({problem}); get it from {SOURCE}") from None
    if table.ndim != 2 or len(table) != 2 or table.shape[1] < 2:
        raise FileError(folder / file, f"holds {variable} of shape {table.shape}; it must be two rows, time and m/s2")
    steps = np.diff(table[0])
    if not np.allclose(steps, steps[0], rtol=1e-6):
        raise FileError(folder / file, "has times that are not evenly spaced; get it again")
    return GroundMotion(table[1], float(steps[0]), name, source=file).scaled(intensity)
