"""Plain columns: accelerations alone, or time [s] and acceleration, separated by blanks, commas,
semicolons or tabs.

Lines that start with # or % are comments, and one line of names may come first. The unit is declared,
``units="g"``, or stands in brackets in the name of the column: ``time [s], acceleration [g]``.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.samples import motion_of, step_of

SUFFIXES = (".txt", ".csv", ".dat")


def read(path: Path, units: str | None = None, dt: float | None = None) -> GroundMotion:
    """The ground motion of a file with one column (needs ``dt``) or two."""
    names, rows = _table(path)
    named = _bracketed(names[-1]) if names else None
    if units and named and units != named:
        raise FileError(path, f"units = {units!r} contradict the column's [{named}]; leave units out")
    unit = units or named
    if unit is None:
        raise FileError(path, "no unit is known for the acceleration; declare it, such as units='g' or units='m/s^2'")
    if rows.shape[1] == 2:
        unit_of_time = _bracketed(names[0]) if len(names) == 2 else None
        if unit_of_time not in (None, "s"):
            raise FileError(path, f"time is in {unit_of_time}; write it in s")
        return motion_of(path, rows[:, 1], step_of(path, rows[:, 0], dt), unit, source=path.name)
    if dt is None:
        raise FileError(path, "holds accelerations only; give the seconds between samples, such as dt=0.02")
    return motion_of(path, rows[:, 0], dt, unit, source=path.name)


def _table(path: Path) -> tuple[list[str], np.ndarray]:
    """The names of the columns, if there are any, and the numbers."""
    names: list[str] = []
    rows: list[list[float]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        text = line.strip().lstrip("\ufeff")
        if not text or text[0] in "#%":
            continue
        numbers = _numbers(text)
        if numbers is None and not rows and not names:
            names = re.split(r"[,;\t]", text)
        elif numbers is None or (rows and len(numbers) != len(rows[0])):
            expected = f"{len(rows[0])} numbers" if rows else "numbers"
            raise FileError(path, f"line {number} is {text[:60]!r}; it must hold {expected}")
        else:
            rows.append(numbers)
    if not rows or len(rows[0]) > 2:
        content = f"{len(rows[0])} columns" if rows else "no numbers"
        raise FileError(
            path, f"holds {content}; a ground motion has one column (acceleration) or two (time, acceleration)"
        )
    return names, np.array(rows)


def _numbers(text: str) -> list[float] | None:
    try:
        return [float(word) for word in re.split(r"[,;\s]+", text) if word]
    except ValueError:
        return None


def _bracketed(name: str) -> str | None:
    match = re.search(r"[\[(]([^\])]+)[\])]", name)
    return match[1].strip() if match else None
