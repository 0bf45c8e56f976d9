"""The components in a file of an accelerograph, as it states them: samples, step, unit and peak.

A format that is recognised by its content gives one `MotionChannel` for each component. What is the same for all of them is
done once, here: the unit and the step are the file's and are not declared again with another value, the peak that the header
names must be that of the samples, and of several components one is chosen by name.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FileError, InputError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.units import to_si

Array = NDArray[np.float64]

PEAK_TOLERANCE = 0.005  # of the header's peak: files that are read rightly agree to 0.2 %
SAME_UNIT = 1e-6  # relative: gal, cm/s2 and cm/sec/sec are one unit
VERTICAL = re.compile(r"\b(U-?D|up|down|vert\w*|Z|[A-Z]{2}Z)\b", re.IGNORECASE)
UNITS = ("cm/s^2", "mm/s^2", "m/s^2", "g")  # that such files are in, however they spell them


@dataclass(frozen=True)
class StatedPeak:
    """The peak that a header names: its size, and half a unit of its last digit."""

    size: float
    rounding: float

    @classmethod
    def of(cls, text: str) -> StatedPeak:
        """From the text in the header, ``-9733.1`` or ``-0.2225194E+03``."""
        mantissa, _, exponent = text.strip().lower().replace("d", "e").partition("e")
        decimals = len(mantissa.partition(".")[2])
        return cls(abs(float(text)), 0.5 * 10.0 ** (int(exponent or 0) - decimals))


@dataclass(frozen=True, eq=False)
class MotionChannel:
    """One component in a file.

    ``values`` (n,) are in ``unit``, every ``dt`` s; ``component`` is what the file calls it, ``recording`` the same text for
    the components that one instrument recorded together, in one file or in several. ``peak`` is the header's, in ``unit``,
    None where it names none; ``notes`` say what was done to the samples.
    """

    component: str
    values: Array
    dt: float
    unit: str
    source: str
    recording: str
    peak: StatedPeak | None = None
    notes: tuple[str, ...] = ()

    @property
    def vertical(self) -> bool:
        """Whether the component's name says up."""
        return VERTICAL.search(self.component) is not None


def unit_of(path: Path, text: str) -> str:
    """The unit that a file states, in dampyr's spelling; :class:`FileError` for one that is not an acceleration's."""
    sizes = {round(float(to_si(1.0, unit, "m/s^2")), 9): unit for unit in UNITS}
    with suppress(InputError, KeyError):
        return sizes[round(float(to_si(1.0, text.lower().replace("cms", "cm"), "m/s^2")), 9)]  # USC writes cms/sec/sec
    raise FileError(
        path,
        f"its samples are in {text.strip()!r}, which is not a unit of acceleration that dampyr knows of such a file "
        f"({', '.join(UNITS)}); fetch the record in physical units",
    )


def motion_of_channel(
    path: Path, channel: MotionChannel, units: str | None = None, dt: float | None = None
) -> GroundMotion:
    """The ground motion of a component; ``units`` and ``dt`` may be given again but must not contradict the file."""
    step_si, stated = float(to_si(1.0, channel.unit, "m/s^2")), channel.unit
    if units is not None and abs(float(to_si(1.0, units, "m/s^2")) / step_si - 1) > SAME_UNIT:
        raise FileError(path, f"units = {units!r} contradict the file's {stated!r}; leave units out")
    if dt is not None and abs(dt - channel.dt) > 1e-6 * channel.dt:
        raise FileError(path, f"dt = {dt:g} s contradicts the file's {channel.dt:g} s; leave dt out")
    if not channel.dt > 0 or not np.isfinite(channel.dt):
        raise FileError(path, f"its step is {channel.dt:g} s; it must be greater than 0, so fetch the file again")
    _check_peak(path, channel)
    name = f"{path.stem} {channel.component}".strip()
    try:
        motion = GroundMotion(
            to_si(channel.values, channel.unit, "m/s^2"), channel.dt, name=name, source=channel.source
        )
    except InputError as problem:
        raise FileError(path, str(problem).removeprefix(f"{name}: ")) from None
    return replace(motion, history=channel.notes) if channel.notes else motion


def _check_peak(path: Path, channel: MotionChannel) -> None:
    peak = channel.peak
    if peak is None or channel.values.size == 0:
        return
    size = float(np.abs(channel.values).max())
    if abs(size - peak.size) > PEAK_TOLERANCE * peak.size + peak.rounding:
        raise FileError(
            path,
            f"{channel.component}: the samples peak at {size:.6g} {channel.unit} and the header says {peak.size:.6g} "
            f"{channel.unit}, more than {100 * PEAK_TOLERANCE:g} % apart; the file was cut or changed, so fetch it again",
        )


def chosen(path: Path, channels: Sequence[MotionChannel], component: str | None) -> MotionChannel:
    """The one channel, or that of several whose name is ``component``, or has it as one of its words."""
    names = ", ".join(channel.component for channel in channels)
    if component is None:
        if len(channels) == 1:
            return channels[0]
        example = channels[0].component
        raise FileError(
            path,
            f"holds {len(channels)} components ({names}); choose one, such as --component {example!r} or "
            f"component={example!r}",
        )
    wanted = component.strip().lower()
    same = [channel for channel in channels if channel.component.lower() == wanted]
    fitting = same or [channel for channel in channels if wanted in re.split(r"[\s:]+", channel.component.lower())]
    if len(fitting) != 1:
        reason = f"fits {len(fitting)} of the components" if fitting else "is not a component of the file"
        raise FileError(path, f"component = {component!r} {reason}; choose from {names}")
    return fitting[0]
