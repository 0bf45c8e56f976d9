"""From columns of numbers to a record: which column is which channel, and each channel in SI.

The columns come from a text (:mod:`dampyr.records.files.text_columns`) or a MATLAB file (:mod:`dampyr.records.formats.mat`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.errors import FileError
from dampyr.input_kinds import NO_INPUT
from dampyr.phrases import listing
from dampyr.records.conditioning.integrated_displacement import with_integrated_displacement
from dampyr.records.conditioning.nominal_input import MEASURED, SOURCE
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import CHANNELS, Array, Record
from dampyr.units import to_si

NAMES = {
    "time": ("time", "t", "tempo", "timestamp"),
    "displacement": ("displacement", "disp", "dist", "position", "stroke", "x"),
    "force": ("force", "forc", "load", "f"),
    "velocity": ("velocity", "speed", "v"),
    "voltage": ("voltage", "u"),
    "current": ("current", "i"),
    "temperature": ("temperature", "temp"),
}
SPELLINGS = {
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "msecs"), "ms"),
    **dict.fromkeys(("newton", "newtons"), "N"),
    **dict.fromkeys(("volt", "volts"), "V"),
    **dict.fromkeys(("amp", "amps", "ampere", "amperes"), "A"),
}
"""Units as testing machines spell them, in lower case."""
TEMPERATURES = {
    **dict.fromkeys(("degc", "°c", "deg c", "deg_c", "celsius", "c"), "degC"),
    **dict.fromkeys(("degf", "°f", "deg f", "deg_f", "fahrenheit", "f"), "degF"),
    **dict.fromkeys(("k", "kelvin"), "kelvin"),
}
"""Units of a temperature, in lower case: there, C and F are no coulomb and no farad."""
MAX_NAMED = 20  # columns that a message lists: a line of a page
HALF_A_DAY = 43200.0  # s: a clock that goes back by more has passed midnight, one that goes back by less is wrong


@dataclass(frozen=True)
class ColumnTable:
    """Columns as a file has them: names, units ("" unknown), both empty without a header, and ``(n, m)`` values.

    ``kinds`` says what each column holds: "number"; or s, of a "clock" since midnight, of a "stamp" and a "date" since the
    midnight before the first. Empty: all are numbers. ``stamps`` are the first row's texts of those that are not numbers, by
    column, ``groups`` what the file says of its session, its specimen and of there being no input,
    ``lines`` the line of each row in the file, ``empty`` the line of the first empty cell of each column that has one, and
    ``notes`` what the history says of how it was read.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    kinds: tuple[str, ...] = ()
    stamps: Mapping[int, str] = field(default_factory=dict)
    groups: Mapping[str, str] = field(default_factory=dict)
    lines: Sequence[int] = ()
    empty: Mapping[int, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def headers(self) -> list[str]:
        """Every column with its unit, ``Force [kN]``."""
        return [f"{name} [{unit}]" if unit else name for name, unit in zip(self.names, self.units)]

    def listed(self) -> str:
        """The columns that a person can choose from; names with their units where two are alike."""
        count = self.values.shape[1]
        if not self.names:
            return f"{count} columns without names, 0 to {count - 1}"
        return listing(self.names if len(set(self.names)) == len(self.names) else self.headers(), MAX_NAMED)

    def kind(self, column: int) -> str:
        """What a column holds: "number", "clock", "date" or "stamp"."""
        return self.kinds[column] if self.kinds else "number"

    def unit(self, column: int) -> str:
        """The unit that the header gives a column, "" where it gives none."""
        return self.units[column] if self.units else ""

    def label(self, column: int) -> str:
        """A column as messages call it: its name in quotes, or its number."""
        return repr(self.names[column]) if self.names else f"number {column}"


def record_of(path: Path, table: ColumnTable, request: ReadOptions, kind: str) -> Record:
    """The record in a table, every channel in SI; ``kind`` is the name of the format."""
    used = _columns(path, table, request)
    _check_needed(path, table, used, request)
    _check_cells(path, table, used)
    _check_units(path, table, used, request)
    channels: dict[str, Any] = {
        name: _in_si(path, table, name, column, request) for name, column in used.items() if name != "time"
    }
    time, stamp, notes = _time(path, table, used.get("time"), request)
    measured = {name: channels.pop(name, None) for name in ("voltage", "current")}
    groups = dict(table.groups)
    inputs = request.input_channels(**measured, no_input=groups.pop("input", None) == NO_INPUT)
    if inputs["voltage"] is not None and inputs["current"] is not None:
        raise FileError(
            path,
            "voltage and current are both given; a record has one input, so leave one out, such as --column voltage=- or "
            "columns={'voltage': None}",
        )
    provenance = {"file": path.name, "format": kind, "header": ", ".join(table.headers())}
    is_measured = any(value is not None and value is inputs[name] for name, value in measured.items())
    fields: dict[str, Any] = dict(
        time=time,
        **channels,
        voltage=_constant(inputs["voltage"]),
        current=_constant(inputs["current"]),
        no_input=inputs["no_input"],
        name=path.stem,
        provenance=provenance | stamp | ({SOURCE: MEASURED} if is_measured else {}),
        history=("read from columns, converted to SI", *table.notes, *notes, *request.replaced(**measured)),
        **groups,
    )
    return Record(**fields) if "displacement" in channels else with_integrated_displacement(**fields)


def name_and_unit(cell: str) -> tuple[str, str]:
    """The two parts of a cell of a header, ``force (N)`` or ``force [N]``; the unit is "" where there is none."""
    match = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*", cell)
    return (match[1].strip(), match[2].strip()) if match else (cell.strip(), "")


def _columns(path: Path, table: ColumnTable, request: ReadOptions) -> dict[str, int]:
    """Which column each channel is: as declared, else by its usual names in the header among the columns that are left."""
    declared = {channel: header for channel, header in request.columns.items() if header != ""}
    used: dict[str, int] = {}
    for channel, header in declared.items():
        if header is None or header == "-":
            continue
        used[channel] = _declared_column(path, table, channel, header)
        twice = [other for other in used if other != channel and used[other] == used[channel]]
        if twice:
            raise FileError(
                path, f"the column {header!r} is declared as the {twice[0]} and as the {channel}; name two columns"
            )
    for channel in CHANNELS:
        if channel not in declared and (column := _by_names(path, table, channel, set(used.values()))) is not None:
            used[channel] = column
    return {channel: used[channel] for channel in CHANNELS if channel in used}


def guess_channels(path: Path, table: ColumnTable) -> dict[str, int]:
    """Channel -> the column that has one of its usual names; those that are not certain are left out."""
    guessed: dict[str, int] = {}
    for channel in CHANNELS:
        with suppress(FileError):
            column = _by_names(path, table, channel, set(guessed.values()))
            guessed |= {} if column is None else {channel: column}
    return guessed


def _declared_column(path: Path, table: ColumnTable, channel: str, declared: str | int) -> int:
    count = table.values.shape[1]
    if isinstance(declared, str):
        matching = _called(table, declared)
        if len(matching) == 1:
            return matching[0]
        if matching:
            which = " and ".join(f"{table.headers()[k]!r} is number {k}" for k in matching)
            raise FileError(
                path, f"{len(matching)} columns are called {declared!r} ({which}); give the full header or the number"
            )
        if not declared.strip().isdigit():
            raise FileError(path, f"there is no column {declared!r}; choose from {table.listed()}")
        declared = int(declared)
    if not 0 <= declared < count:
        raise FileError(
            path, f"columns[{channel!r}] = {declared} is not a column; choose a number from 0 to {count - 1}"
        )
    return declared


def _by_names(path: Path, table: ColumnTable, channel: str, taken: set[int]) -> int | None:
    lower = [name.lower() for name in table.names]
    matching = [k for word in NAMES[channel] for k, name in enumerate(lower) if name == word and k not in taken]
    if len(matching) > 1:
        names = " and ".join(table.headers()[k] for k in matching)
        raise FileError(
            path,
            f"the columns {names} could all be the {channel}; declare which, --column {channel}=NAME or "
            f"columns={{{channel!r}: NAME}}, by the full header or the number from 0",
        )
    return matching[0] if matching else None


def _called(table: ColumnTable, declared: str) -> list[int]:
    """The columns of this header; else of this name with its unit; else of this name, in upper or lower case."""
    exact = [k for k, (name, header) in enumerate(zip(table.names, table.headers())) if declared in (name, header)]
    if len(exact) == 1:
        return exact
    name, unit = (part.lower() for part in name_and_unit(declared))
    lower, whole = [name.lower() for name in table.names], declared.strip().lower()
    called = [k for k, other in enumerate(lower) if other in (name, whole)]
    with_unit = [k for k in called if unit and table.units[k].lower() == unit]
    if unit and not with_unit:  # brackets that are part of the name, and no unit
        return [k for k in called if lower[k] == whole]
    return with_unit or called


def _check_needed(path: Path, table: ColumnTable, used: dict[str, int], request: ReadOptions) -> None:
    """Time (or ``dt``), force, and displacement or velocity have to be there."""
    if request.dt is not None and "time" in used:
        raise FileError(
            path,
            f"dt = {request.dt:g} s was given, but the column {table.label(used['time'])} is the time; leave one of them "
            "out, such as --column time=- or columns={'time': None}",
        )
    instead = {"time": request.dt is not None, "displacement": "velocity" in used}
    absent = [name for name in ("time", "displacement", "force") if name not in used and not instead.get(name)]
    if absent:
        *others, last = (f"the {name}" for name in absent)
        missing = f"{', '.join(others)} or {last}" if others else last
        options = " ".join(f"--column {name}=NAME" for name in absent)
        call = ", ".join(f"{name!r}: NAME" for name in absent)
        also = ", or give the sampling interval: --dt 0.001, dt=0.001" if "time" in absent else ""
        raise FileError(
            path,
            f"no column is {missing} (there: {table.listed()}); declare which, {options} or columns={{{call}}}{also}",
        )


def _check_cells(path: Path, table: ColumnTable, used: dict[str, int]) -> None:
    """All but the time must be numbers, and no cell may be empty."""
    for channel, column in used.items():
        if channel != "time" and table.kind(column) != "number":
            raise FileError(
                path,
                f"the column of the {channel} holds {table.stamps[column]!r}, which is not a number; declare another, "
                f"--column {channel}=NAME or columns={{{channel!r}: NAME}}",
            )
        if column in table.empty:
            raise FileError(
                path, f"line {table.empty[column]}: the cell of the {channel} is empty; repair or cut out the line"
            )


def _check_units(path: Path, table: ColumnTable, used: dict[str, int], request: ReadOptions) -> None:
    """Raise :class:`FileError` with every column that has no unit, not the first one only."""
    bare = [
        channel
        for channel, column in used.items()
        if table.kind(column) == "number" and not (table.unit(column) or request.units.get(channel))
    ]
    if bare:
        names = ", ".join(table.label(used[channel]) for channel in bare)
        raise FileError(
            path,
            f"the {'columns' if len(bare) > 1 else 'column'} {names} {'have' if len(bare) > 1 else 'has'} no unit; write it in "
            f"the header, such as {bare[0]} [{CHANNELS[bare[0]]}], or declare it: --unit {bare[0]}={CHANNELS[bare[0]]}, "
            f"units={{{bare[0]!r}: {CHANNELS[bare[0]]!r}}} or in reading.toml",
        )


def _time(
    path: Path, table: ColumnTable, column: int | None, request: ReadOptions
) -> tuple[Array, dict[str, str], tuple[str, ...]]:
    """The time in s, the text of its first stamp for the provenance, and what the history says of it."""
    if column is None:
        assert request.dt is not None
        n = len(table.values)
        return request.dt * np.arange(n, dtype=float), {}, (f"time from the sampling interval, {request.dt:g} s",)
    kind = table.kind(column)
    if kind == "number":
        return _in_si(path, table, "time", column, request), {}, ()
    seconds, first = table.values[:, column], table.stamps[column]
    note = "time stamps as s from the first one"
    if kind == "clock":
        dates = [k for k in range(table.values.shape[1]) if table.kind(k) == "date"]
        if len(dates) == 1:
            seconds, first = seconds + table.values[:, dates[0]], f"{table.stamps[dates[0]]} {first}"
        else:
            midnights = np.cumsum(np.diff(seconds, prepend=seconds[0]) < -HALF_A_DAY)
            seconds = seconds + 86400.0 * midnights
            note += ", past midnight" * bool(midnights[-1])
    elif kind == "date":
        raise FileError(path, f"the column of the time holds dates alone ({first}); declare the column of the clock")
    repeated = np.flatnonzero(np.diff(seconds) == 0)
    if len(repeated):
        k = int(repeated[0])
        where = f"lines {table.lines[k]} and {table.lines[k + 1]}" if table.lines else f"rows {k} and {k + 1}"
        raise FileError(
            path,
            f"{where} have the same time stamp ({len(repeated)} such pairs): the clock is coarser than the samples; give their "
            "interval, such as --column time=- --dt 0.01, or columns={'time': None} and dt=0.01",
        )
    day = re.match(r"(\d{4})\D(\d{1,2})\D(\d{1,2})", first)
    date = {"date": "{}-{:0>2}-{:0>2}".format(*day.groups())} if day else {}
    return seconds - seconds[0], {"first_sample": first} | date, (note,)


def _in_si(path: Path, table: ColumnTable, channel: str, column: int, request: ReadOptions) -> Array:
    stated = table.unit(column)
    declared = request.units.get(channel, "")
    if stated and declared and _spelled(stated, channel) != _spelled(declared, channel):
        raise FileError(
            path,
            f"the header says {channel} is in {stated!r}, but units declares {declared!r}; leave it out of units",
        )
    unit = _spelled(declared or stated, channel)
    values = table.values[:, column]
    return values if unit == CHANNELS[channel] else to_si(values, unit, CHANNELS[channel])


def _spelled(unit: str, channel: str) -> str:
    """A unit as :func:`dampyr.units.to_si` spells it."""
    word = unit.strip().lower()
    return (TEMPERATURES if channel == "temperature" else SPELLINGS).get(word, unit)


def _constant(values: Any) -> Any:
    """A channel that never changes is a constant input."""
    return float(values[0]) if np.ndim(values) == 1 and len(values) and np.ptp(values) == 0 else values
