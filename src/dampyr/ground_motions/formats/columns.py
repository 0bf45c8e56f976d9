"""Columns of text: accelerations alone, one or several in a line, or a table with a time, read as those of records are.

The text is read by :mod:`dampyr.text_table`. A table names its columns, with their units, or they are declared; of two columns
without names the first is the time. More columns without names are a series, line by line, unless the first one rises evenly
as a time does. Lines above the numbers may say the step, the number of samples and the unit: ``1203 0.0100``, ``NPTS= 1203,
DT= .01 SEC``, ``1203 points at equal spacing of 0.01 sec``, ``UNITS OF G``, ``The units are (g)``.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dampyr import channel_columns, text_table
from dampyr.channel_columns import ColumnTable
from dampyr.errors import FileError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_options import ACCELERATION, MotionReadOptions
from dampyr.ground_motions.samples import motion_of, step_of

SUFFIXES = (".txt", ".csv", ".dat", ".acc")
TAKES_OPTIONS = True
_NUMBER = r"([-+]?\d*[.,]?\d+(?:[eEdD][-+]?\d+)?)"
_SAMPLES = (
    re.compile(rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*{_NUMBER}", re.IGNORECASE),
    re.compile(rf"^\s*(\d+)[\s,]+{_NUMBER}[\s,]+NPTS\s*,?\s*DT", re.IGNORECASE),
    re.compile(rf"(\d+)\s+points\s+at\s+equal\s+spacing\s+of\s+{_NUMBER}\s*sec", re.IGNORECASE),
)
_UNIT = re.compile(r"\bUNITS?\s*(?:OF|ARE|:|=)\s*\(?\s*([^\s()]+?)\s*\)?[.,;]*(?:\s|$)", re.IGNORECASE)
_FIRST_LINE = re.compile(rf"^[ \t]*(\d+)[ \t,;]+{_NUMBER}[ \t]*$", re.MULTILINE)
HEAD = 10_000  # characters in which the numbers begin
_FIRST_NUMBER = re.compile(r"\s*[-+]?[\d.]")


@dataclass(frozen=True)
class Stated:
    """What lines above the numbers say: the number of samples, their step [s] and the unit, each None where they do not."""

    count: int | None = None
    dt: float | None = None
    unit: str | None = None
    is_prose: bool = False
    """Whether a sentence says it, which may count the steps in the place of the samples."""


def read(
    path: Path, units: str | None = None, dt: float | None = None, options: MotionReadOptions | None = None
) -> GroundMotion:
    """The ground motion of a file of columns; ``units`` are those of the acceleration, where the file does not say them."""
    request = options or MotionReadOptions()
    request = replace(request, units={**request.units, **({ACCELERATION: units} if units else {})})
    text, note = text_table.decoded(path, request.encoding)
    table = _table(path, _with_count_in_words(path, text, request), request, note)
    return motion_of_table(path, table, stated_in(table.above), request, dt, source=path.name)


def _table(path: Path, text: str, request: MotionReadOptions, note: str = "") -> ColumnTable:
    notes = (note,) if note else ()
    try:
        return text_table.table_of_text(path, text, request, by_number=True, least=1, series=True, notes=notes)
    except FileError as problem:
        if "no line of numbers" in str(problem):
            raise FileError(
                path, "holds no numbers; a ground motion has one acceleration or more in each line"
            ) from None
        raise


def _with_count_in_words(path: Path, text: str, request: MotionReadOptions) -> str:
    """The text, its first line of numbers as a comment where it says how many numbers follow and their step: 1203 0.0100."""
    match = _FIRST_LINE.search(text, 0, HEAD)
    if match is None or int(match[1]) < 2 or any(map(_FIRST_NUMBER.match, text[: match.start()].split("\n"))):
        return text
    in_words = f"{text[: match.start()]}# NPTS= {match[1]}, DT= {match[2]} SEC{text[match.end() :]}"
    with suppress(FileError):
        table = _table(path, in_words, request)
        if table.values.size - table.short == int(match[1]):
            return in_words
    return text


def stated_in(lines: tuple[str, ...]) -> Stated:
    """What the lines of a header say."""
    counts = [match for line in lines for style in _SAMPLES if (match := style.search(line))]
    units = [match[1] for line in lines if (match := _UNIT.search(line))]
    step = _float(counts[0][2]) if counts else 0.0
    return Stated(
        int(counts[0][1]) if step > 0 else None,
        step if step > 0 else None,
        {"g's": "g", "gs": "g"}.get(units[0].lower(), units[0].lower()) if units else None,
        is_prose=bool(counts) and counts[0].re is _SAMPLES[-1],
    )


def motion_of_table(
    path: Path, table: ColumnTable, stated: Stated, request: MotionReadOptions, dt: float | None, source: str
) -> GroundMotion:
    """The ground motion in a table, with what a header and a caller state of it; where these disagree an error."""
    column, time, values, notes = _acceleration(path, table, stated, request)
    is_series = values.size != len(table.values)  # then the lines above are prose, and no names of columns
    if stated.count is not None and abs(len(values) - stated.count) > stated.is_prose:
        raise FileError(
            path,
            f"the header says NPTS = {stated.count} but {len(values)} values follow; fetch the file again or correct NPTS",
        )
    unit = (not is_series and table.unit(column)) or stated.unit or ""
    names = table.names[column : column + 1] if not is_series else ()
    series = ColumnTable(names, (unit,), values[:, None], lines=table.lines)
    declared = request.units.get(ACCELERATION)
    if not (unit or declared or request.factor(ACCELERATION)[1]):
        raise FileError(
            path,
            "no unit is known for the acceleration; declare it, such as --motion-unit g, units='g' or units='m/s^2'",
        )
    in_si, said = channel_columns.in_si(path, series, ACCELERATION, 0, request)
    if time is None:
        step = _agreed(path, stated.dt, dt)
    else:
        timed = request if table.unit(time) or "time" in request.units or "time" in request.factors else None
        timed = timed or replace(request, units={**request.units, "time": "s"})
        seconds, more = channel_columns.in_si(path, table, "time", time, timed)
        try:
            step = step_of(path, seconds, None)
        except FileError:
            if dt is None:
                raise
            step, more = dt, (channel_columns.check_interval(path, table, time, seconds, dt),)
        else:
            step = step_of(path, seconds, dt)
        said = (*said, *more)
    motion = motion_of(path, in_si, step, "m/s^2", source=source)
    return replace(motion, history=(*table.notes, *notes, *said))


def _acceleration(
    path: Path, table: ColumnTable, stated: Stated, request: MotionReadOptions
) -> tuple[int, int | None, np.ndarray, tuple[str, ...]]:
    """The column of the acceleration and that of the time or None, the accelerations (n,), and what the history says."""
    width = table.values.shape[1]
    used = channel_columns.columns_of(path, table, request)
    if (
        ACCELERATION not in used
        and not request.columns
        and width == 2
        and stated.count != table.values.size - table.short
    ):
        used = {"time": 0, ACCELERATION: 1}
    if ACCELERATION in used or "time" in used:
        if ACCELERATION not in used:
            raise FileError(
                path,
                f"no column is the acceleration (there: {table.listed()}); declare which, --column acceleration=NAME or "
                "columns={'acceleration': NAME}",
            )
        channel_columns.check_cells(path, table, used)
        if table.short and stated.count is None:
            raise FileError(
                path,
                f"line {table.lines[-1]} has {width - table.short} values and line {table.lines[0]} has {width}; "
                "repair the line",
            )
        return used[ACCELERATION], used.get("time"), table.values[:, used[ACCELERATION]], ()
    if table.empty:
        raise FileError(path, f"line {min(table.empty.values())} has an empty cell; repair or cut out the line")
    steps = np.diff(table.values[:, 0])
    if (
        width > 2
        and len(steps) > 2
        and not stated.count
        and np.all(steps > 0)
        and np.ptp(steps) <= 0.01 * np.mean(steps)
    ):
        raise FileError(
            path,
            f"holds {width} columns without names, and the first one rises evenly as a time does; say which is which, such as "
            "--column time=0 --column acceleration=1 or columns={'time': 0, 'acceleration': 1}",
        )
    values = table.values.ravel()[: table.values.size - table.short]
    return 0, None, values, (f"{width} values a line, read line by line",) * (width > 1 and not stated.count)


def _agreed(path: Path, stated: float | None, dt: float | None) -> float:
    if stated is not None and dt is not None and abs(dt - stated) > 1e-6 * stated:
        raise FileError(path, f"dt = {dt:g} s contradicts the header's DT = {stated:g} s; leave dt out")
    step = stated if stated is not None else dt
    if step is None:
        raise FileError(
            path, "holds accelerations only; give the seconds between samples, such as --dt 0.02 or dt=0.02"
        )
    return step


def _float(text: str) -> float:
    return float(text.replace(",", ".").lower().replace("d", "e"))
