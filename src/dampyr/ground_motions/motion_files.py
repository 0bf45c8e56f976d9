"""Reading a ground motion from a file: the format follows from the suffix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from dampyr import registry
from dampyr.errors import FileError, MissingData
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_options import ACCELERATION, MotionReadOptions
from dampyr.options import takes
from dampyr.source_file import check_name

REGISTRY = "dampyr.ground_motions.formats"


def available_formats() -> dict[str, tuple[str, ...]]:
    """The formats that can be read, and their suffixes."""
    return {name: module.SUFFIXES for name, module in registry.members(REGISTRY)}


@takes(MotionReadOptions)
def read(
    path: str | Path,
    units: str | Mapping[str, str] | None = None,
    dt: float | None = None,
    options: MotionReadOptions | None = None,
    **keywords: Any,
) -> GroundMotion:
    """The ground motion in a file.

    Parameters
    ----------
    path
        The file; its suffix says which format it is.
    units
        Unit of the acceleration, such as "g" or "m/s^2", or units by channel; needed where the file does not name it.
    dt
        Seconds between samples; needed where the file holds accelerations only.
    options
        the further arguments as one object; those that are given by name take their places.

    Raises
    ------
    MissingData
        There is no such file.
    FileError
        The file contradicts itself or the arguments, or holds values that are not numbers.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.arange(0.0, 2.0, 0.01)
    >>> np.savetxt("pulse.txt", np.column_stack([t, 0.4 * np.sin(6 * t)]))
    >>> motion = dp.ground_motions.read("pulse.txt", units="g")
    >>> motion.n, round(motion.dt, 6), round(motion.pga, 2)
    (200, 0.01, 3.92)
    """
    file = Path(path)
    request = MotionReadOptions.of("read", options, keywords)
    stated = {**request.units, **(units if isinstance(units, Mapping) else {ACCELERATION: units} if units else {})}
    unit = stated.pop(ACCELERATION, None)
    request = replace(request, units=stated)
    if not file.is_file():
        raise MissingData(f"{file}: there is no such file; check the path of the ground motion")
    check_name(file)
    for _, module in registry.members(REGISTRY):
        if file.suffix.lower() in module.SUFFIXES:
            if getattr(module, "TAKES_OPTIONS", False):
                motion: GroundMotion = module.read(file, unit, dt, request)
            else:
                request.refuse(file, **dict.fromkeys(request.as_keywords(), "this format has no columns to declare"))
                motion = module.read(file, unit, dt)
            return motion
    available = ", ".join(sorted(suffix for suffixes in available_formats().values() for suffix in suffixes))
    raise FileError(file, f"the suffix {file.suffix!r} is not a ground motion's; dampyr reads {available}")
