"""Slow passes of a run: what they have shown of the load cell and the damper, kept with the rig for the next run.

Within a run the passes before and after a test tell a gain of the load cell's chain that changes between them. One that has
changed before the run began shows on none of them; what tells is what the passes of earlier runs were, with the same specimen,
over the same place and by the same calibration of the cell. They lie in ``slow_passes.toml`` beside a ``rig.toml``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import tomli_w

from dampyr.atomic_write import write_whole
from dampyr.config import fill, load_toml
from dampyr.errors import FileError, InputError
from dampyr.rig.calibration import Calibration
from dampyr.units import Quantity

NAME = "slow_passes.toml"
VERSION = 1
SIDE = 1.0e-3  # m on both sides of the place about which a slow pass goes: hysteresis saturates in it
GENTLE = 0.010  # m/s, the mean speed of a pass, and on the way to the start of a test
NEAR = 5.0  # K within which passes are taken together
MOST = 4  # passes that are kept for each such step of the temperature
HEAD = (
    "# The latest slow passes with each specimen; the next run with it compares its first one with them.\n"
    "# Delete those of a damper that has changed, or this file.\n"
)


@dataclass(frozen=True)
class SlowPass:
    """What a slow way down and up again over the same place has shown, with the coil at 0 V (`ArmedRig.verify`)."""

    mean: Annotated[float, Quantity("N")]
    """Mean of the forces of both ways: the load cell's zero and the static force there."""
    height: Annotated[float, Quantity("N")]
    """Half of what they are apart: friction and damping alone, by the gain of the load cell's chain."""
    noise: Annotated[float, Quantity("V")] = math.nan
    """rms from sample to sample (`dampyr.rig.cell_noise`); NaN where it tells nothing."""
    temperature: Annotated[float, Quantity("degC")] = math.nan
    """Of the damper, measured or estimated."""
    place: Annotated[float, Quantity("m")] = 0.0
    specimen: str = ""
    """The damper that it went over; "" where nothing names it."""
    cell: str = ""
    """Calibration of the load cell, as `cell_of` states it."""
    time: str = ""
    """UTC, ISO 8601."""
    amplitude: Annotated[float, Quantity("m")] = SIDE
    speed: Annotated[float, Quantity("m/s")] = GENTLE
    voltage: Annotated[float, Quantity("V")] = 0.0

    def is_alike(self, other: SlowPass) -> bool:
        """Whether both went over the same place of the same specimen, and were driven and calibrated in the same way."""
        same = ("specimen", "cell", "amplitude", "speed", "voltage")
        return (
            bool(self.specimen)
            and abs(self.place - other.place) < self.amplitude
            and all(getattr(self, name) == getattr(other, name) for name in same)
        )


def cell_of(calibration: Calibration, scale_uncertainty: float, bandwidth: float) -> str:
    """What identifies a calibration of the load cell: its scale, with its relative uncertainty, and its bandwidth.

    The zero is read again and again, and says nothing of the gain.
    """
    return f"{calibration.scale!r} N/V +-{scale_uncertainty:.6g}, {bandwidth!r} Hz"


def usual_pass(kept: Sequence[SlowPass], first: SlowPass) -> SlowPass | None:
    """The mean of the kept passes that are like the ``first`` of a run and nearest to its temperature; None where none is.

    A height errs by some tenths of a newton from pass to pass, and the mean of several by less.
    """
    alike = [one for one in kept if one.is_alike(first)]
    nearest = min(alike, key=lambda one: abs(one.temperature - first.temperature), default=None)
    if nearest is None:
        return None
    near = [one for one in alike if abs(one.temperature - nearest.temperature) <= NEAR]
    names = ("mean", "height", "noise", "temperature")
    means = {name: sum(getattr(one, name) for one in near) / len(near) for name in names}
    return replace(near[-1], **means)


def with_run(kept: Iterable[SlowPass], passes: Sequence[SlowPass]) -> tuple[SlowPass, ...]:
    """The kept passes and those of a run, without the older ones of its specimen beyond `MOST` for each `NEAR` kelvin, and
    those that are not like it, as of before the cell was calibrated anew."""
    last = passes[-1]
    others = tuple(one for one in kept if one.specimen != last.specimen)
    by_temperature: dict[int, list[SlowPass]] = {}
    for one in (*(one for one in kept if one.is_alike(last)), *passes):
        by_temperature.setdefault(round(one.temperature / NEAR), []).append(one)
    return others + tuple(one for group in by_temperature.values() for one in group[-MOST:])


def save_passes(folder: Path, kept: Iterable[SlowPass]) -> Path:
    """Write ``slow_passes.toml`` beside a ``rig.toml``, whole or not at all; `FileError` where the disk takes nothing."""
    path = folder / NAME
    rows = [_known(one) for one in kept]
    try:
        write_whole(path, HEAD + tomli_w.dumps({"version": VERSION, "pass": rows}))
    except OSError as problem:
        raise FileError(path, f"cannot be written ({problem.strerror or problem}); make room") from problem
    return path


def load_passes(folder: Path) -> tuple[SlowPass, ...]:
    """The passes beside a ``rig.toml``; none without the file, :class:`FileError` where it is wrong."""
    path = folder / NAME
    if not path.is_file():
        return ()
    document = load_toml(path)
    again = "move it away: the next run then begins a new comparison"
    if document.get("version") != VERSION:
        version = document.get("version", "none")
        raise FileError(
            path, f"has the version {version!r}, and this dampyr reads {VERSION}; take a newer one, or {again}"
        )
    rows = document.get("pass", [])
    try:
        if not isinstance(rows, list):
            raise InputError(f"pass = {rows!r} must be a list of tables")
        return tuple(fill(SlowPass, row, f"pass {number}") for number, row in enumerate(rows, 1))
    except InputError as problem:
        raise FileError(path, f"{problem}; or {again}") from None


def _known(one: SlowPass) -> dict[str, Any]:
    """What a pass tells, SI."""
    return {name: value for name, value in asdict(one).items() if value == value}  # NaN is not
