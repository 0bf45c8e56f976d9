"""Reading a ground motion from a file: its first lines say which format it is, and where they do not, its suffix."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from dampyr import registry
from dampyr.errors import FileError, MissingData
from dampyr.ground_motions.channels import MotionChannel, chosen, motion_of_channel
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_options import ACCELERATION, MotionReadOptions
from dampyr.ground_motions.motion_reading import merged, options_beside
from dampyr.options import takes
from dampyr.source_file import check_name
from dampyr.text_table import decoded

REGISTRY = "dampyr.ground_motions.formats"
HEAD = 1 << 14  # bytes, in which a format shows what it is
LINE_ENDS = re.compile(r"\r*\n|\r")  # CR CR LF too, as files have that were copied as text twice


def available_formats() -> dict[str, tuple[str, ...]]:
    """The formats that can be read, and their suffixes."""
    return {name: module.SUFFIXES for name, module in registry.members(REGISTRY)}


@takes(MotionReadOptions)
def read(
    path: str | Path,
    units: str | Mapping[str, str] | None = None,
    dt: float | None = None,
    component: str | None = None,
    options: MotionReadOptions | None = None,
    **keywords: Any,
) -> GroundMotion:
    """The ground motion in a file.

    What no argument states of a plain file is taken from the ``reading.toml`` beside it, where there is one
    (:mod:`dampyr.ground_motions.motion_reading`).

    Parameters
    ----------
    path
        The file; its first lines say which format it is, and where they do not, its suffix.
    units
        Unit of the acceleration, such as "g" or "m/s^2", or units by channel; needed where the file does not name it.
    dt
        Seconds between samples; needed where the file holds accelerations only.
    component
        Of a file with several: what the file calls it, such as "N-S", or a word of that which no other has.
    options
        the further arguments as one object; those that are given by name take their places.

    Raises
    ------
    MissingData
        There is no such file.
    FileError
        The file contradicts itself or the arguments, holds values that are not numbers, or several components of which none
        is chosen.

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
    request = MotionReadOptions.of("read", options, keywords)
    stated = {**request.units, **(units if isinstance(units, Mapping) else {ACCELERATION: units} if units else {})}
    unit = stated.pop(ACCELERATION, None)
    request = replace(request, units=stated)
    file = _existing(path)
    _, module = format_of(file)
    takes_options = getattr(module, "TAKES_OPTIONS", False)
    if takes_options:
        unit, dt, request = _with_reading(file, unit, dt, request)
    else:
        request.refuse(file, **dict.fromkeys(request.as_keywords(), "this format has no columns to declare"))
    if hasattr(module, "channels"):
        return motion_of_channel(file, chosen(file, read_channels(file, module), component), unit, dt)
    if component is not None:
        raise FileError(file, f"component = {component!r} was given, but the file has one acceleration; leave it out")
    motion: GroundMotion = module.read(file, unit, dt, *((request,) if takes_options else ()))
    return motion


def _with_reading(
    file: Path, unit: str | None, dt: float | None, request: MotionReadOptions
) -> tuple[str | None, float | None, MotionReadOptions]:
    """What is declared of a file, and where nothing is, what the ``reading.toml`` beside it says."""
    beside = options_beside(file)
    dt = beside.pop("dt", None) if dt is None else dt
    beside.pop("dt", None)
    stated = {name: value for name, value in request.as_keywords().items() if value not in (None, {})}
    options = MotionReadOptions(**merged(beside, stated))
    of_folder = options.units.get(ACCELERATION)
    others = {channel: text for channel, text in options.units.items() if channel != ACCELERATION}
    return unit or of_folder, dt, replace(options, units=others)


def read_components(path: str | Path, units: str | None = None, dt: float | None = None) -> dict[str, GroundMotion]:
    """Every component in a file by the name that the file gives it; "" for that of a file which names none.

    Arguments and errors are those of `read`.
    """
    file = _existing(path)
    _, module = format_of(file)
    if not hasattr(module, "channels"):
        return {"": read(file, units, dt)}
    return {channel.component: motion_of_channel(file, channel, units, dt) for channel in read_channels(file, module)}


def component_names(path: str | Path) -> list[str]:
    """What a file calls the components in it, to choose from with `read`; none where its format names none."""
    file = _existing(path)
    _, module = format_of(file)
    return [channel.component for channel in read_channels(file, module)] if hasattr(module, "channels") else []


def read_channels(file: Path, module: ModuleType) -> list[MotionChannel]:
    """The components in a file of a format that is recognised by its content."""
    lines = decoded(file)[0].split("\n")
    if not module.recognises(lines):
        raise FileError(
            file,
            f"is not a file of {module.TITLE}, as its suffix says: it begins with {lines[0].strip()[:60]!r} and must have "
            f"{module.SIGNATURE}",
        )
    channels: list[MotionChannel] = module.channels(file, lines)
    names = [channel.component for channel in channels]
    if len(set(names)) < len(names):
        raise FileError(file, f"two components have one name ({', '.join(names)}); split the file")
    return channels


def format_of(file: Path) -> tuple[str, ModuleType]:
    """The name and the module of the file's format, by its first lines, else by its suffix."""
    with file.open("rb") as stream:
        # any bytes are Latin-1, and numbers and words of a header are ASCII
        head = LINE_ENDS.split(stream.read(HEAD).removeprefix(b"\xef\xbb\xbf").decode("latin-1"))
    available = list(registry.members(REGISTRY))
    for name, module in available:
        if hasattr(module, "recognises") and module.recognises(head):
            return name, module
    for name, module in available:
        if file.suffix.lower() in module.SUFFIXES:
            return name, module
    suffixes = ", ".join(sorted(suffix for _, module in available for suffix in module.SUFFIXES))
    raise FileError(file, f"the suffix {file.suffix!r} is not a ground motion's; dampyr reads {suffixes}")


def _existing(path: str | Path) -> Path:
    file = Path(path)
    if not file.is_file():
        raise MissingData(f"{file}: there is no such file; check the path of the ground motion")
    check_name(file)
    return file
