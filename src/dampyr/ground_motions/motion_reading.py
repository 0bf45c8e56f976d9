"""``reading.toml`` beside ground motions: what their files do not state, stated once, in its table ``[motions]``.

Everything may be left out; the names are those of `MotionReadOptions`, and ``dt`` [s] is that of `read`::

    [motions]
    dt = 0.01
    units = { acceleration = "g" }

    [[motions.files]]              # what holds for some of them only, and goes before
    pattern = "logger*"            # of a file's name, with or without its suffix
    columns = { time = "Clock", acceleration = "Channel 3" }
    encoding = "cp1252"

What a call or the command line says goes before what stands here. What stands outside of the table is of records
(:mod:`dampyr.records.files.folder_metadata`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from dampyr.config import load_toml
from dampyr.errors import FileError, InputError
from dampyr.ground_motions.motion_options import MotionReadOptions

NAME = "reading.toml"
TABLE = "motions"
NAMES = tuple(field.name for field in fields(MotionReadOptions))


def options_beside(file: Path) -> dict[str, Any]:
    """What the ``reading.toml`` beside a file says of it, by the names of `MotionReadOptions` and ``dt``.

    Raises FileError for a name that is not known, a value that is not allowed, and two patterns that say different things.
    """
    path = file.parent / NAME
    table = load_toml(path).get(TABLE, {}) if path.is_file() else {}
    if not isinstance(table, dict):
        raise FileError(path, f"{TABLE} = {table!r} is not a table; write what it says below [{TABLE}]")
    general = _checked(path, {name: value for name, value in table.items() if name != "files"}, f"[{TABLE}] ")
    special: dict[str, Any] = {}
    for number, section in enumerate(table.get("files", []), 1):
        where = f"[[{TABLE}.files]] {number}: "
        pattern = section.get("pattern")
        if not isinstance(pattern, str):
            raise FileError(path, f'{where}pattern = {pattern!r} is not a pattern; write it as in "logger*"')
        stated = _checked(path, {name: value for name, value in section.items() if name != "pattern"}, where)
        if not (fnmatchcase(file.name, pattern) or fnmatchcase(file.stem, pattern)):
            continue
        twice = next((name for name in stated if special.get(name, stated[name]) != stated[name]), None)
        if twice is not None:
            raise FileError(
                path,
                f"{where}{pattern!r} and a pattern above give {file.name} two values of {twice}; make them exclusive",
            )
        special |= stated
    return merged(general, special)


def merged(general: Mapping[str, Any], special: Mapping[str, Any]) -> dict[str, Any]:
    """Both, of which the second goes before; tables of channels are joined channel by channel."""
    tables = {
        name: {**general[name], **special[name]}
        for name in general.keys() & special.keys()
        if isinstance(general[name], Mapping)
    }
    return {**general, **special, **tables}


def _checked(path: Path, values: dict[str, Any], where: str) -> dict[str, Any]:
    unknown = sorted(values.keys() - {*NAMES, "dt"})
    if unknown:
        raise FileError(path, f"{where}{unknown[0]!r} is not known; choose from {', '.join((*NAMES, 'dt'))}")
    dt = values.get("dt", 1.0)
    if isinstance(dt, bool) or not isinstance(dt, int | float) or not dt > 0:
        raise FileError(path, f"{where}dt = {dt!r} is not allowed; it must be a number greater than 0, in s")
    try:
        MotionReadOptions(**{name: value for name, value in values.items() if name != "dt"})
    except InputError as problem:
        raise FileError(path, f"{where}{problem}") from None
    return values
