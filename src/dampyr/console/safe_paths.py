"""Names from outside as places below the data folder: nothing above it, no link, no hidden file."""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from dampyr.errors import InputError, MissingData

NEW_NAME = re.compile(r"[^\W_][\w .()+@=-]{0,99}", re.UNICODE)
NO_PART = frozenset('<>:"|?*/\\')
"""What parts a path, or what some system does not allow in a name."""
RESERVED = frozenset(
    [
        "con",
        "prn",
        "aux",
        "nul",
        *(f"{port}{k}" for port in ("com", "lpt") for k in (*range(10), "\u00b9", "\u00b2", "\u00b3")),
    ]
)
"""What Windows takes for a device, with any suffix."""
MAX_NAME = 255  # bytes: what a file system takes
MAX_NAME_LENGTH = 600  # characters of a path below the data folder
MAX_FILES = 20_000  # that are looked at below a folder: the list of a page shows 500
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
            f'{name[:60]!r} is not a valid file name; leave out <>:"|?*\\ and what is not printed, begin it with a letter or '
            "a digit, and separate folders by /"
        )
    place = root
    for part in parts:
        place = place / part
        if place.is_symlink():
            raise InputError(f"{name!r} is a link, and links are not followed; copy the file itself")
    return place


def is_name(text: str) -> bool:
    """Whether a text is the name of one file or folder: printable, nothing that parts a path, no dot, space, ~ or - first."""
    return (
        bool(text)
        and text.isprintable()
        and not NO_PART & set(text)
        and text[0] not in ".-~ "
        and text[-1] not in ". "
        and len(text.encode("utf-8", "surrogateescape")) <= MAX_NAME
    )


def is_new_name(text: str) -> bool:
    """Whether a file may be written under a name: letters, digits, space and .()+@=-_ , at most 100 of them, and no device."""
    return bool(NEW_NAME.fullmatch(text)) and is_name(text) and not is_reserved(text)


def is_reserved(text: str) -> bool:
    """Whether Windows takes a name for a device, whatever its suffix."""
    return text.partition(".")[0].strip().lower() in RESERVED


def check_new_name(text: str) -> None:
    """Refuse a name under which no file can be written, with the reason."""
    if is_reserved(text):
        raise InputError(
            f"{text[:60]!r} is the name of a device on Windows, which cannot hold such a file; choose another name"
        )
    if not is_new_name(text):
        raise InputError(f"{text[:60]!r} is not a file name; use letters, digits, space and .()+@=-_")


def new_name(text: str) -> str:
    """A name under which a file that is called ``text`` elsewhere can be written; "" where nothing of it is left."""
    stem, dot, suffix = text.rpartition(".") if "." in text else (text, "", "")
    safe = re.sub(r"[^\w .()+@=-]", "_", stem, flags=re.UNICODE).strip(" ._-~+@=()")[: 90 - len(suffix)].strip(" .")
    return f"{safe}{dot}{suffix}" if safe and is_new_name(f"{safe}{dot}{suffix}") else ""


def why_left_out(path: Path) -> str:
    """Why `files` leaves out a file or folder, "" where it does not."""
    if path.is_symlink():
        return "it is a link, and links are not followed; copy the file itself"
    if not is_name(path.name):
        return "its name cannot be used here; rename it with letters, digits, space and .()+@=-_"
    return ""


def existing(root: Path, name: str) -> Path:
    """The file called ``name`` below ``root``, which is there; else MissingData."""
    place = inside(root, name)
    if not place.is_file():
        raise MissingData(f"{name}: there is no such file")
    return place


def files(root: Path, suffixes: tuple[str, ...]) -> list[str]:
    """The names of the files below ``root`` with one of the suffixes, sorted; links and hidden ones left out."""
    return sorted(path.relative_to(root).as_posix() for path, why in _walk(root, suffixes) if not why)


def left_out(root: Path, suffixes: tuple[str, ...]) -> dict[str, str]:
    """The files and folders that `files` leaves out, but hidden ones, each with the reason."""
    return {
        path.relative_to(root).as_posix().encode("utf-8", "replace").decode(): why
        for path, why in _walk(root, suffixes)
        if why
    }


def _walk(root: Path, suffixes: tuple[str, ...]) -> Iterator[tuple[Path, str]]:
    seen = 0
    for folder, inner, names in os.walk(root, followlinks=False):
        inner[:] = sorted(name for name in inner if not name.startswith("."))
        refused = {name: why for name in inner if (why := why_left_out(Path(folder, name)))}
        yield from ((Path(folder, name), why) for name, why in refused.items())
        inner[:] = [name for name in inner if name not in refused]
        for name in names:
            path = Path(folder, name)
            if path.suffix.lower() in suffixes and not name.startswith("."):
                yield path, why_left_out(path)
            seen += 1
        if seen > MAX_FILES:
            return


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
