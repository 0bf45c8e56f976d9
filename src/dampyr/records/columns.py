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
from dampyr.records.files import Request
from dampyr.records.record import CHANNELS, Array, Record
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


@dataclass(frozen=True)
class Table:
    """Columns of numbers as found in a text file: names, units ("" unknown) and ``(n, m)`` values."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array


def read(path: Path, request: Request, kind: str) -> Record:
    """The record in a text file of columns, every channel in SI."""
    table = read_table(path)
    found: dict[str, Any] = {}
    for channel in CHANNELS:
        column = _column(path, table, channel, request)
        if column is not None:
            found[channel] = _in_si(path, table, channel, column, request)
    for channel in ("time", "displacement", "force"):
        if channel not in found:
            there = ", ".join(table.names) or f"{table.values.shape[1]} columns without names"
            raise FileError(path, f"no column is the {channel} (there: {there}); declare columns={{{channel!r}: ...}}")
    found |= request.input_channels(*(_constant(found.pop(name, None)) for name in ("voltage", "current")))
    units = ", ".join(f"{name} [{unit}]" for name, unit in zip(table.names, table.units))
    return Record(
        **found,
        name=path.stem,
        provenance={"file": path.name, "format": kind, "header": units},
        history=("read from columns, converted to SI",),
    )


def read_table(path: Path) -> Table:
    """The numbers of a text file with the header above them."""
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except UnicodeDecodeError as problem:
        raise FileError(path, f"is no UTF-8 text (byte {problem.start}); save it as UTF-8 text") from None
    header, rows, first = _split(lines)
    if not rows:
        raise FileError(path, "has no line of numbers; give a header and one line per sample")
    delimiter = _delimiter(rows)
    values = _numbers(path, rows, first, delimiter)
    cells = [cell.strip().strip('"') for cell in _cells(header, delimiter)] if header else []
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


def _split(lines: list[str]) -> tuple[str, list[tuple[int, str]], int]:
    """The header line, the ``(line number, text)`` rows below it, and the number of the first row's line."""
    header = ""
    for number, line in enumerate(lines, start=1):
        bare = line.strip()
        if bare and _starts_with_number(bare):
            rows = [(k, text) for k, text in enumerate(lines[number - 1 :], start=number) if text.strip()]
            return header, [(k, text) for k, text in rows if text.strip()[0] not in "#%"], number
        if bare.lstrip("#% "):
            header = bare.lstrip("#% ")
    return header, [], len(lines)


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
    return line.split(delimiter) if delimiter else line.split()


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
    said = request.columns.get(channel)
    lower = [name.lower() for name in table.names]
    if isinstance(said, int):
        if not 0 <= said < table.values.shape[1]:
            last = table.values.shape[1] - 1
            raise FileError(path, f"columns[{channel!r}] = {said} is no column; choose a number from 0 to {last}")
        return said
    if said is not None:
        if said.lower() not in lower:
            raise FileError(path, f"there is no column {said!r}; choose from {', '.join(table.names)}")
        return lower.index(said.lower())
    fits = [k for word in WORDS[channel] for k, name in enumerate(lower) if name == word]
    if len(fits) > 1:
        names = " and ".join(table.names[k] for k in fits)
        raise FileError(path, f"the columns {names} could all be the {channel}; declare columns={{{channel!r}: ...}}")
    return fits[0] if fits else None


def _in_si(path: Path, table: Table, channel: str, column: int, request: Request) -> Array:
    stated = table.units[column] if table.units else ""
    declared = request.units.get(channel, "")
    unit = declared or stated
    if not unit:
        name = table.names[column] if table.names else f"{column}"
        raise FileError(
            path,
            f"the column {name!r} has no unit; write it in the header, such as {channel} "
            f"[{CHANNELS[channel]}], or declare units={{{channel!r}: {CHANNELS[channel]!r}}}",
        )
    if stated and declared and stated != declared:
        raise FileError(
            path,
            f"the header says {channel} is in {stated!r}, but units declares {declared!r}; leave it out of units",
        )
    unit = unit.replace("°C", "degC") if channel == "temperature" else unit
    values = table.values[:, column]
    return values if unit == CHANNELS[channel] else to_si(values, unit, CHANNELS[channel])


def _constant(values: Array | None) -> float | Array | None:
    """A channel that never changes is a constant input."""
    if values is None or not len(values) or np.ptp(values) != 0:
        return values
    return float(values[0])
