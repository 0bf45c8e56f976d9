"""The ground motions in a folder: what each file holds, or why it is refused, and which components belong together."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from dampyr.errors import FileError, InputError, MissingData, one_line
from dampyr.ground_motions.channels import motion_of_channel
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_files import format_of, read, read_channels
from dampyr.ground_motions.motion_reading import NAME
from dampyr.shown import Shown
from dampyr.source_file import check_name


@dataclass(frozen=True, eq=False, repr=False)
class MotionEntry(Shown):
    """A component in a file, or a file that is refused, whose ``problem`` is a sentence and ``motion`` None."""

    file: str  # its name, without the folder
    format: str  # as `available_formats` calls it; "" where none is known
    component: str  # as the file calls it; "" where it names none
    motion: GroundMotion | None
    problem: str = ""
    recording: str = ""  # the same for components that one instrument recorded together; "" where the file does not say
    vertical: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class MotionTable(Shown):
    """The ground motions in a folder, or the components in a file, in the order of their names."""

    path: str
    entries: tuple[MotionEntry, ...]

    @property
    def motions(self) -> list[GroundMotion]:
        """Those that could be read."""
        return [entry.motion for entry in self.entries if entry.motion is not None]

    @property
    def horizontal_pairs(self) -> list[tuple[GroundMotion, GroundMotion]]:
        """The two horizontal components of each recording that has two of one step and length, for `rotated_spectrum`."""
        recordings: dict[str, list[MotionEntry]] = {}
        for entry in self.entries:
            if entry.motion is not None and entry.recording and not entry.vertical:
                recordings.setdefault(entry.recording, []).append(entry)
        pairs = []
        for entries in recordings.values():
            # two files of one component are two versions of it
            if len(entries) == 2 and entries[0].component != entries[1].component:
                first, second = (entry.motion for entry in entries)
                if first and second and (first.n, first.dt) == (second.n, second.dt):
                    pairs.append((first, second))
        return pairs


def read_folder(folder: str | Path, units: str | None = None, dt: float | None = None) -> MotionTable:
    """What is in a folder of ground motions: a row for each component of each file, or the reason why a file is refused.

    Parameters
    ----------
    folder
        The folder; hidden files and folders in it are left out. A file gives the components in it.
    units, dt
        Unit of the acceleration and seconds between samples of the plain files that do not state them; what a file states
        itself is taken from there.

    Raises
    ------
    MissingData
        There is no such folder or it holds no file.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> np.savetxt("pulse.txt", 0.4 * np.sin(0.06 * np.arange(200)))
    >>> table = dp.ground_motions.read_folder("pulse.txt", units="g", dt=0.01)
    >>> [(entry.file, entry.format, round(entry.motion.pga, 2)) for entry in table.entries]
    [('pulse.txt', 'columns', 3.92)]
    """
    folder = Path(folder)
    if not folder.exists():
        raise MissingData(f"{folder}: there is no such file or folder; check the path of the ground motions")
    files = (
        [folder] if folder.is_file() else [path for path in folder.iterdir() if path.is_file() and path.name != NAME]
    )
    files = sorted((path for path in files if not path.name.startswith(".")), key=_natural)
    if not files:
        raise MissingData(f"{folder}: the folder has no files; give a folder of ground motions")
    return MotionTable(str(folder), tuple(entry for path in files for entry in _entries(path, units, dt)))


def _entries(path: Path, units: str | None, dt: float | None) -> list[MotionEntry]:
    name = ""
    try:
        check_name(path)
        name, module = format_of(path)
        if not hasattr(module, "channels"):
            component, recording, vertical = (
                module.component_of(path) if hasattr(module, "component_of") else ("", "", False)
            )
            return [MotionEntry(path.name, name, component, read(path, units, dt), "", recording, vertical)]
        entries = []
        for channel in read_channels(path, module):
            entry = MotionEntry(path.name, name, channel.component, None, "", channel.recording, channel.vertical)
            try:
                entries.append(replace(entry, motion=motion_of_channel(path, channel)))
            except FileError as problem:
                entries.append(replace(entry, problem=_sentence(path, problem)))
        return entries
    except (InputError, OSError) as problem:
        return [MotionEntry(path.name, name, "", None, _sentence(path, problem))]


def _sentence(path: Path, problem: Exception) -> str:
    return one_line(problem).removeprefix(f"{path}: ")


def _natural(path: Path) -> tuple[tuple[str | int, ...], str]:
    """The order in which a person lists files: record2 before record10."""
    parts = re.split(r"(\d+)", path.name.lower())
    return tuple(int(part) if k % 2 else part for k, part in enumerate(parts)), path.name
