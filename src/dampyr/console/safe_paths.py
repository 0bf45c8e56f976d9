"""Names from outside as places below the data folder: nothing above it, no link, no hidden file."""

from __future__ import annotations

import os
import re
import threading
from pathlib import Path, PurePosixPath

from dampyr.errors import InputError, MissingData

NAME = re.compile(r"[^\W_][\w .()+@=-]{0,99}", re.UNICODE)
MAX_NAME_LENGTH = 300  # characters of a path below the data folder
OWN = ".console"
"""The console's own folder below the data folder: jobs, notes."""
ALONE = threading.Lock()
"""Held from the look whether a file is there until it is: of two pages that save the same name at once one is told."""


def inside(root: Path, name: str) -> Path:
    """The place called ``name``, such as ``lab/test 1.csv``, below ``root``; it need not exist.

    Raises InputError for a name that leads out, is hidden, or passes a link.
    """
    parts = PurePosixPath(name).parts if len(name) <= MAX_NAME_LENGTH else ()
    if not parts or "\\" in name or name.startswith("/") or not all(map(is_name, parts)):
        raise InputError(
            f"{name[:60]!r} is not a valid file name; use letters, digits, space and .()+@=-_ , folders separated by /"
        )
    place = root
    for part in parts:
        place = place / part
        if place.is_symlink():
            raise InputError(f"{name!r} is a link, and links are not followed; copy the file itself")
    return place


def is_name(text: str) -> bool:
    """Whether a text is the name of one file or folder: no dot or space first or last, nothing that parts a path."""
    return bool(NAME.fullmatch(text)) and text == text.strip() and not text.endswith(".")


def existing(root: Path, name: str) -> Path:
    """The file called ``name`` below ``root``, which is there; else MissingData."""
    place = inside(root, name)
    if not place.is_file():
        raise MissingData(f"{name}: there is no such file")
    return place


def files(root: Path, suffixes: tuple[str, ...]) -> list[str]:
    """The names of the files below ``root`` with one of the suffixes, sorted; links and hidden ones left out."""
    paths = []
    for folder, inner, names in os.walk(root, followlinks=False):
        inner[:] = [name for name in inner if is_name(name)]
        for name in names:
            path = Path(folder, name)
            if path.suffix.lower() in suffixes and is_name(name) and not path.is_symlink():
                paths.append(path.relative_to(root).as_posix())
    return sorted(paths)


def used(root: Path) -> int:
    """Bytes of all files below ``root``; one that goes while they are counted has none."""
    return sum(_size(Path(folder, name)) for folder, _, names in os.walk(root) for name in names)


def _size(path: Path) -> int:
    try:
        return path.lstat().st_size
    except FileNotFoundError:
        return 0


def check_quota(root: Path, more: int, quota: int) -> None:
    """Refuse to write ``more`` bytes where the data folder would pass ``quota`` bytes."""
    if used(root) + more > quota:
        raise InputError(
            f"the data folder would pass its {quota / 2**20:.0f} MiB; delete what is not needed, or start with a larger --quota"
        )


def data_of(job: Path) -> Path:
    """The data folder that a job's folder lies in."""
    return job.parents[2]
