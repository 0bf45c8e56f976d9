"""Records in columns of text: the header names each channel and its unit, the delimiter is found.

A header cell is a name and a unit in brackets or parentheses: ``time [s]``, ``displacement [mm]``, ``force
(N)``. Lines that start with ``#`` or ``%`` are comments; the last line before the numbers is the header, even
as a comment. A comma is the decimal mark where the delimiter is a semicolon, a tab or white space.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.errors import FileError
from dampyr.records.nominal_input import MEASURED, SOURCE
from dampyr.records.record import CHANNELS, Array, Record
from dampyr.records.record_files import Request
from dampyr.units import to_si

WORDS = {
    "time": ("time", "t", "tempo"),
    "displacement": ("displacement", "disp", "dist", "position", "stroke", "x"),
    "force": ("force", "forc", "load", "f"),
    "velocity": ("velocity", "speed", "v"),
    "voltage": ("voltage", "u"),
    "current": ("current", "i"),
    "temperature": ("temperature", "temp"),
}
DELIMITERS = (";", "\t", ",", None)
BARE_UNITS = {
    *("s", "sec", "ms", "m", "cm", "mm", "um", "µm", "in", "inch", "n", "kn", "lbf", "kip"),
    *("m/s", "cm/s", "mm/s", "in/s", "v", "mv", "a", "ma", "degc", "°c", "g"),
}
"""What a cell in a line of units below the names may be, in lower case."""


@dataclass(frozen=True)
class Table:
    """Columns of numbers as found in a text file: names, units ("" unknown) and ``(n, m)`` values."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array


def read(path: Path, request: Request, kind: str) -> Record:
    """The record in a text file of columns, every channel in SI."""
    table = read_table(path)
    columns = {channel: _column(path, table, channel, request) for channel in CHANNELS}
    used = {channel: column for channel, column in columns.items() if column is not None}
    for channel in ("time", "displacement", "force"):
        if channel not in used:
            there = ", ".join(table.names) or f"{table.values.shape[1]} columns without names"
            raise FileError(
                path,
                f"no column is the {channel} (there: {there}); declare which, --column {channel}=NAME or "
                f"columns={{{channel!r}: NAME}}",
            )
    _check_units(path, table, used, request)
    channels: dict[str, Any] = {name: _in_si(path, table, name, column, request) for name, column in used.items()}
    measured = {name: channels.pop(name, None) for name in ("voltage", "current")}
    inputs: dict[str, Any] = request.input_channels(**measured)
    _check_one_input(path, inputs)
    units = ", ".join(f"{name} [{unit}]" if unit else name for name, unit in zip(table.names, table.units))
    provenance = {"file": path.name, "format": kind, "header": units}
    is_measured = any(value is not None and value is measured[name] for name, value in inputs.items())
    return Record(
        **channels,
        voltage=_constant(inputs["voltage"]),
        current=_constant(inputs["current"]),
        name=path.stem,
        provenance=provenance | ({SOURCE: MEASURED} if is_measured else {}),
        history=("read from columns, converted to SI", *request.replaced(**measured)),
    )


def has_numbers(path: Path) -> bool:
    """Whether a text file has a line of two or more numbers and nothing else, as every record has."""
    lines = path.read_text("utf-8-sig", errors="replace").splitlines()
    return any(_is_numbers(line) for line in lines)


def _is_numbers(line: str) -> bool:
    cells = [cell for cell in re.split(r"[;\t\s]+|,\s+", line.strip().strip(";,")) if cell]
    cells = cells if len(cells) > 1 else line.strip().strip(",").split(",")
    try:
        return len([float(cell.strip().strip('"').replace(",", ".")) for cell in cells]) > 1
    except ValueError:
        return False


def read_table(path: Path) -> Table:
    """The numbers of a text file with the header above them."""
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except UnicodeDecodeError as problem:
        raise FileError(path, f"is no UTF-8 text (byte {problem.start}); save it as UTF-8 text") from None
    header, above, rows, first = _split(lines)
    if not rows:
        raise FileError(path, "has no line of numbers; give a header and one line per sample")
    delimiter = _delimiter(rows)
    values = _numbers(path, rows, first, delimiter)
    cells = _with_units_below(*(_header_cells(line, delimiter) for line in (above, header)))
    if cells and len(cells) != values.shape[1]:
        glued = _glued(header)
        if len(glued) != values.shape[1]:
            raise FileError(
                path,
                f"the header names {len(cells)} columns and the first line has {values.shape[1]} numbers; "
                "repair the header",
            )
        cells = glued
    pairs = [_name_and_unit(cell) for cell in cells]
    return Table(tuple(name for name, _ in pairs), tuple(unit for _, unit in pairs), values)


def _split(lines: list[str]) -> tuple[str, str, list[tuple[int, str]], int]:
    """The header line, the one above it, the ``(line number, text)`` rows below, and the number of the first row's line."""
    header = above = ""
    for number, line in enumerate(lines, start=1):
        bare = line.strip()
        if bare and _starts_with_number(bare):
            rows = [(k, text) for k, text in enumerate(lines[number - 1 :], start=number) if text.strip()]
            return header, above, [(k, text) for k, text in rows if text.strip()[0] not in "#%"], number
        if bare.lstrip("#% "):
            header, above = bare.lstrip("#% "), header
    return header, above, [], len(lines)


def _header_cells(line: str, delimiter: str | None) -> list[str]:
    return [cell.strip().strip('"') for cell in _cells(line, delimiter)] if line else []


def _with_units_below(names: list[str], cells: list[str]) -> list[str]:
    """The cells of the header; where its last line is units only, each after the name above it."""
    bare = [cell.strip("[]() ") for cell in cells]
    if len(names) != len(cells) or not all(unit in ("", "-") or unit.lower() in BARE_UNITS for unit in bare):
        return cells
    return [f"{name} [{unit}]" if unit not in ("", "-") else name for name, unit in zip(names, bare)]


def _starts_with_number(line: str) -> bool:
    first = re.split(r"[;\t,\s]", line, maxsplit=1)[0].strip('"')
    try:
        return math.isfinite(float(first)) or first.lower() == "nan"
    except ValueError:
        return False


def _delimiter(rows: list[tuple[int, str]]) -> str | None:
    """The first delimiter that stands in the first row; None is white space."""
    line = rows[0][1].strip()
    return next((d for d in DELIMITERS if d is not None and d in line and not _is_decimal_comma(d, line)), None)


def _is_decimal_comma(delimiter: str, line: str) -> bool:
    """A comma inside white-space columns, such as ``0,01  1,5``, is a decimal mark."""
    parts = line.split()
    return (
        delimiter == "," and len(parts) > 1 and all(re.fullmatch(r"[+-]?\d+(,\d+)?([eE][+-]?\d+)?", p) for p in parts)
    )


def _cells(line: str, delimiter: str | None) -> list[str]:
    """The cells of a line; a delimiter at its end, as spreadsheets leave it, makes none."""
    cells = line.split(delimiter) if delimiter else line.split()
    return cells[:-1] if len(cells) > 1 and not cells[-1].strip() else cells


def _glued(header: str) -> list[str]:
    """The cells of a white-space header whose names stand apart from their units: ``force (N)``."""
    return re.findall(r"[^\s\[\]()]+(?:\s*[\[(][^\])]*[\])])?", header)


def _numbers(path: Path, rows: list[tuple[int, str]], first: int, delimiter: str | None) -> Array:
    width = len(_cells(rows[0][1].strip(), delimiter))
    values = np.empty((len(rows), width))
    for k, (number, line) in enumerate(rows):
        cells = _cells(line.strip(), delimiter)
        if len(cells) != width:
            raise FileError(
                path, f"line {number} has {len(cells)} values and line {first} has {width}; repair the line"
            )
        for j, cell in enumerate(cells):
            text = cell.strip().strip('"')
            try:
                values[k, j] = float(text if delimiter == "," else text.replace(",", "."))
            except ValueError:
                raise FileError(path, f"line {number}: {text!r} is not a number; repair or cut out the line") from None
    return values


def _name_and_unit(cell: str) -> tuple[str, str]:
    match = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*", cell)
    return (match[1].strip(), match[2].strip()) if match else (cell.strip(), "")


def _column(path: Path, table: Table, channel: str, request: Request) -> int | None:
    """Which column a channel is: as declared, else by the words of the header."""
    said = request.columns.get(channel, "")
    if said is None or said == "-":
        return None
    lower = [name.lower() for name in table.names]
    if isinstance(said, int):
        if not 0 <= said < table.values.shape[1]:
            last = table.values.shape[1] - 1
            raise FileError(path, f"columns[{channel!r}] = {said} is no column; choose a number from 0 to {last}")
        return said
    if said:
        if said.lower() not in lower:
            raise FileError(path, f"there is no column {said!r}; choose from {', '.join(table.names)}")
        return lower.index(said.lower())
    fits = [k for word in WORDS[channel] for k, name in enumerate(lower) if name == word]
    if len(fits) > 1:
        names = " and ".join(table.names[k] for k in fits)
        raise FileError(
            path,
            f"the columns {names} could all be the {channel}; declare which, --column {channel}=NAME or "
            f"columns={{{channel!r}: NAME}}",
        )
    return fits[0] if fits else None


def _check_units(path: Path, table: Table, used: dict[str, int], request: Request) -> None:
    """Raise :class:`FileError` with every column that has no unit, not the first one only."""
    stated = {channel: table.units[column] if table.units else "" for channel, column in used.items()}
    bare = [channel for channel in used if not (stated[channel] or request.units.get(channel))]
    if bare:
        names = ", ".join(repr(table.names[used[channel]]) if table.names else str(used[channel]) for channel in bare)
        raise FileError(
            path,
            f"the {'columns' if len(bare) > 1 else 'column'} {names} {'have' if len(bare) > 1 else 'has'} no unit; write it in "
            f"the header, such as {bare[0]} [{CHANNELS[bare[0]]}], or declare it: --unit {bare[0]}={CHANNELS[bare[0]]}, "
            f"units={{{bare[0]!r}: {CHANNELS[bare[0]]!r}}} or in reading.toml",
        )


def _check_one_input(path: Path, inputs: dict[str, Any]) -> None:
    if all(value is not None for value in inputs.values()):
        raise FileError(
            path,
            "voltage and current are both given; a record has one input, so leave one out, such as --column voltage=- or "
            "columns={'voltage': None}",
        )


def _in_si(path: Path, table: Table, channel: str, column: int, request: Request) -> Array:
    stated = table.units[column] if table.units else ""
    declared = request.units.get(channel, "")
    unit = declared or stated
    if stated and declared and stated != declared:
        raise FileError(
            path,
            f"the header says {channel} is in {stated!r}, but units declares {declared!r}; leave it out of units",
        )
    unit = unit.replace("°C", "degC") if channel == "temperature" else unit
    values = table.values[:, column]
    return values if unit == CHANNELS[channel] else to_si(values, unit, CHANNELS[channel])


def _constant(values: Any) -> Any:
    """A channel that never changes is a constant input."""
    return float(values[0]) if np.ndim(values) == 1 and len(values) and np.ptp(values) == 0 else values
