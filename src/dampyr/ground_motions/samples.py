"""Conversion of a file's samples into a ground motion; errors name the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FileError, InputError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.units import to_si

Array = NDArray[np.float64]


def motion_of(path: Path, values: Array, dt: float, units: str, source: str) -> GroundMotion:
    """The ground motion of ``values`` in ``units``; what is wrong with them is said with the path in
    front."""
    try:
        return GroundMotion(to_si(values, units, "m/s^2"), dt, name=path.stem, source=source)
    except InputError as problem:
        raise FileError(path, str(problem).removeprefix(f"{path.stem}: ")) from None


def step_of(path: Path, time: Array, dt: float | None) -> float:
    """The even step of a time column that starts anywhere; it must agree with ``dt`` where that is given."""
    if len(time) < 2:
        raise FileError(path, f"holds {len(time)} sample; a ground motion needs at least 2")
    bad = np.flatnonzero(~np.isfinite(time))
    if len(bad):
        raise FileError(path, f"time is not finite at sample {bad[0] + 1}; repair or cut the record")
    steps = np.diff(time)
    mean = float((time[-1] - time[0]) / (len(time) - 1))
    instead = f", or give the step in the place of the times: --dt {mean:.4g}, dt={mean:.4g}" * (mean > 0)
    if np.any(steps <= 0):
        k = int(np.argmax(steps <= 0))
        raise FileError(
            path,
            f"time does not increase from sample {k + 1} ({time[k]:g} s) to {k + 2} ({time[k + 1]:g} s); "
            f"sort the rows{instead}",
        )
    if np.max(np.abs(steps - mean)) > 0.01 * mean:
        k = int(np.argmax(np.abs(steps - mean)))
        raise FileError(
            path,
            f"the step is {steps[k]:g} s after sample {k + 1} but {mean:g} s on average; resample to an even step{instead}",
        )
    if dt is not None and abs(dt - mean) > 1e-3 * mean:
        raise FileError(path, f"dt = {dt:g} s contradicts its time column, {mean:g} s; leave dt out")
    return float(f"{mean:.9g}")
