"""Tables of text: the header names each column and its unit, the delimiter and the decimal mark are recognised.

A header cell is a name and a unit in brackets or parentheses: ``time [s]``, ``displacement [mm]``, ``force
(N)``. Lines that start with ``#`` or ``%`` are comments; the last line before the numbers is the header, even
as a comment, and a line of units may follow the names. A comma is the decimal mark where the delimiter is a semicolon, a tab
or white space. A text that is not UTF-8 is read as Latin-1, and the record's history says so. A column
may hold times of day (``10:00:00.123``), dates (``2026-03-01``) or both (``2026-03-01T10:00:00.123``).
"""

from __future__ import annotations

import codecs
import io
import re
from array import array
from collections.abc import Iterable, Iterator
from contextlib import suppress
from datetime import date
from itertools import chain
from pathlib import Path
from typing import TextIO

import numpy as np

from dampyr.errors import FileError
from dampyr.input_kinds import NO_INPUT
from dampyr.origin import ORIGIN_KINDS
from dampyr.records.files.column_table import SPELLINGS, TEMPERATURES, ColumnTable, name_and_unit, record_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import GROUPS, Array, Record

MAX_COLUMNS = 1000  # of a line: a test has some ten channels; a file with more is written the wrong way round
DELIMITERS = (";", "\t", ",")
BARE_UNITS = {
    *("s", "ms", "min", "m", "cm", "mm", "um", "µm", "in", "inch", "inches", "n", "kn", "lbf", "kip", "kips"),
    *("m/s", "cm/s", "mm/s", "in/s", "m/sec", "mm/sec", "in/sec", "v", "mv", "a", "ma", "g"),
    *SPELLINGS,
    *TEMPERATURES,
}
"""What a cell in a line of units below the names may be, in lower case."""
DAY = r"(\d{4})[-/](\d{1,2})[-/](\d{1,2})"
CLOCK = r"(\d{1,2}):(\d{2}):(\d{2}(?:\.\d*)?)"
DECIMAL_COMMA = rf"[+-]?\d+(,\d+)?([eE][+-]?\d+)?|{DAY}|\d{{1,2}}:\d{{2}}:\d{{2}}(,\d*)?"
KINDS = {
    "clock": re.compile(CLOCK),
    "date": re.compile(DAY),
    "stamp": re.compile(rf"{DAY}(?:T|\s+){CLOCK}\s*(Z|[+-]\d{{2}}:?\d{{2}})?"),
}
"""What a cell may be besides a number."""
KIND_NAMES = {"number": "a number", "clock": "a time of day", "date": "a date", "stamp": "a date with a time of day"}
GROUP = re.compile(
    rf"[#%]\s*(?:({'|'.join(GROUPS)})\s*:\s*(\S.*)|(origin)\s*:\s*({'|'.join(ORIGIN_KINDS)})|(input)\s*:\s*({NO_INPUT})\s*$)"
)
"""A comment above the numbers that states the session, the specimen, the origin, or that there is no input, as dampyr writes
it."""


def read(path: Path, request: ReadOptions, kind: str) -> Record:
    """The record in a text file of columns, every channel in SI."""
    request.refuse(path, variable="a text has columns and no variables")
    return record_of(path, read_table(path, request.header, is_by_number(request)), request, kind)


def is_by_number(request: ReadOptions) -> bool:
    """Whether every column is declared by its number, so that no name is needed."""
    columns = [column for column in request.columns.values() if column not in (None, "-")]
    return bool(columns) and all(isinstance(column, int) or column.isdigit() for column in columns)


def has_numbers(path: Path) -> bool:
    """Whether a text file has a line of two or more numbers, and nothing else but times, as every record has.

    A file with a line of too many columns counts as a record, so that reading it says what is wrong with it.
    """
    lines = (line.strip() for line in io.StringIO(_decoded(path)[0], newline=None))
    return any(_is_too_wide(line) or _is_row(line) for line in lines)


def read_table(path: Path, header: int | None = None, by_number: bool = False) -> ColumnTable:
    """The numbers of a text file with the header above them.

    ``header`` is the line of the names, from 1, or 0 where there is none; None: the last before the numbers, or before a line
    of units. ``by_number``: no name is needed, so that a header which does not fit the columns is left out.
    """
    text, note = _decoded(path)
    return table_of_text(path, text, header, by_number, (note,) if note else ())


def table_of_text(
    path: Path, text: str, header: int | None = None, by_number: bool = False, notes: tuple[str, ...] = ()
) -> ColumnTable:
    """As `read_table`, of a text that came from ``path``; ``notes`` go to the record's history."""
    remaining = io.StringIO(text, newline=None)
    lines, first = _first_row(path, remaining, header)
    rows = _Rows(lines[first:], first, remaining)
    delimiter = _delimiter(lines[first].strip())
    kinds, values, empty = _values(path, rows, delimiter, quoted='"' in text)
    cells = [] if header == 0 else _header(path, lines[:first], header, delimiter, values.shape[1], by_number)
    pairs = [name_and_unit(cell) for cell in cells]
    texts = _texts(lines[first], delimiter)
    return ColumnTable(
        names=tuple(name for name, _ in pairs),
        units=tuple(unit for _, unit in pairs),
        values=values,
        kinds=kinds,
        stamps={k: texts[k] for k, kind in enumerate(kinds) if kind != "number"},
        groups={
            name: text.strip()
            for line in lines[:first]
            if (match := GROUP.fullmatch(line.strip()))
            for name, text in [filter(None, match.groups())]
        },
        lines=rows.numbers,
        empty=empty,
        notes=notes,
    )


def _decoded(path: Path) -> tuple[str, str]:
    """The text of a file, and what the history says where it is no UTF-8."""
    content = path.read_bytes()
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        with suppress(UnicodeDecodeError):
            return content.decode("utf-16"), "read as UTF-16 text"
    try:
        return content.decode("utf-8-sig"), ""
    except UnicodeDecodeError as problem:
        if b"\0" in content:
            raise FileError(path, f"is not a text (byte {problem.start}); choose a text file") from None
    return content.decode("cp1252", errors="replace"), "read as Latin-1 (Windows-1252) text, as it is not UTF-8"


class _Rows:
    """The lines with numbers, one after the other, without blank ones and comments; ``numbers`` are those of the lines."""

    def __init__(self, begun: list[str], first: int, remaining: TextIO) -> None:
        self.begun, self.first, self.remaining = begun, first, remaining
        self.start = remaining.tell()
        self.numbers = array("L")

    def __iter__(self) -> Iterator[str]:
        """From the first one on, as often as it is asked for."""
        self.remaining.seek(self.start)
        self.numbers = array("L")
        for number, line in enumerate(chain(self.begun, self.remaining), start=self.first + 1):
            text = line.strip()
            if text and text[0] not in "#%":
                self.numbers.append(number)
                yield text


def _is_too_wide(line: str) -> bool:
    return len(line) > MAX_COLUMNS and max(map(line.count, ",;\t ")) > MAX_COLUMNS


def _first_row(path: Path, remaining: TextIO, header: int | None) -> tuple[list[str], int]:
    """The lines up to the first of numbers, and where the numbers begin; a line right above them with something else in a
    place of a number counts with them.
    """
    start = header or 0
    lines: list[str] = []
    for line in remaining:
        if _is_too_wide(line):
            raise FileError(
                path,
                f"line {len(lines) + 1} has more than {MAX_COLUMNS} columns, a record has a line for each sample; "
                "write it so, or leave out columns",
            )
        lines.append(line.rstrip("\n"))
        if len(lines) > start and _is_row(lines[-1].strip()):
            break
    else:
        if header is not None and header >= max(len(lines), 1):
            raise FileError(
                path, f"header = {header}, but the file has {len(lines)} lines; give the line of the names, from 1"
            )
        raise FileError(path, "has no line of numbers; give a header and one line per sample")
    first = len(lines) - 1
    delimiter = _delimiter(lines[first].strip())
    width = len(_texts(lines[first], delimiter))
    for k in range(first - 1, start - 1, -1):
        cells = _texts(lines[k], delimiter)
        if not lines[k].strip() or len(cells) != width or _kind(cells[0], delimiter) is None:
            break
        first = k
    return lines, first


def _header(
    path: Path, above: list[str], line: int | None, delimiter: str | None, width: int, by_number: bool
) -> list[str]:
    """The cells of the header, each name with its unit; none where there is no header."""
    texts = [text.strip().lstrip("#% ") for text in above]
    if line is None:
        # the names, and what may be a line of units below them
        names, last = ["", "", *(text for text in texts if text and not GROUP.fullmatch(f"# {text}"))][-2:]
    else:
        names = texts[line - 1]
        last = next((text for text in texts[line:] if text), names)
    cells = _with_units_below(_texts(names, delimiter), _texts(last, delimiter))
    if line is not None and cells == _texts(last, delimiter):
        cells = _texts(names, delimiter)
    if not cells or len(cells) == width:
        return cells
    # names that stand apart from their units in columns of white space: force (N)
    spaced = re.findall(r"[^\s\[\]()]+(?:\s*[\[(][^\])]*[\])])?", last if line is None else names)
    if len(spaced) == width:
        return spaced
    if by_number:
        return []
    raise FileError(
        path,
        f"the header names {len(cells)} columns and the first line has {width} numbers; repair the header, or say which line "
        "it is, from 1, or 0 where there is none: --header 0, header=0",
    )


def _with_units_below(names: list[str], cells: list[str]) -> list[str]:
    """The cells of the header; where its last line is units only, each after the name above it."""
    bare = [cell.strip("[]() ") for cell in cells]
    if len(names) != len(cells) or not all(unit in ("", "-") or unit.lower() in BARE_UNITS for unit in bare):
        return cells
    return [f"{name} [{unit}]" if unit not in ("", "-") else name for name, unit in zip(names, bare)]


def _is_row(line: str) -> bool:
    """Whether a line is two or more numbers, with times and dates between them or without."""
    if not line or line[0] in "#%":
        return False
    delimiter = _delimiter(line)
    kinds = [_kind(cell, delimiter) for cell in _texts(line, delimiter)]
    return None not in kinds and kinds.count("number") > 1


def _delimiter(line: str) -> str | None:
    """The first delimiter that stands in a line of numbers; None is white space."""
    delimiter = next((mark for mark in DELIMITERS if mark in line), None)
    parts = line.split()
    # a comma inside columns of white space, such as 0,01  1,5, is a decimal mark
    if delimiter == "," and len(parts) > 1 and all(re.fullmatch(DECIMAL_COMMA, part) for part in parts):
        return None
    return delimiter


def _texts(line: str, delimiter: str | None) -> list[str]:
    """The cells of a line without quotes; a delimiter at its end, as spreadsheets leave it, makes none."""
    bare = line.strip()
    if not bare:
        return []
    cells = bare.split(delimiter) if delimiter else bare.split()
    cells = cells[:-1] if len(cells) > 1 and not cells[-1].strip() else cells
    return [cell.strip().strip('"') for cell in cells]


def _kind(cell: str, delimiter: str | None) -> str | None:
    """What a cell is: "number", "clock", "date", "stamp", or None."""
    text = cell if delimiter == "," else cell.replace(",", ".")
    try:
        float(text)
        return "number"
    except ValueError:
        return next((kind for kind, pattern in KINDS.items() if pattern.fullmatch(text)), None)


def _values(
    path: Path, rows: _Rows, delimiter: str | None, quoted: bool
) -> tuple[tuple[str, ...], Array, dict[int, int]]:
    """What each column holds by the first row, the values ``(n, m)`` as numbers or s, and the line of its first empty cell.

    An empty cell is NaN: a column that says something once, in the first row, may be left out of a record.
    """
    line = next(iter(rows))
    cells = _texts(line, delimiter)
    kinds = tuple(_kind(cell, delimiter) or "number" for cell in cells)
    if not quoted and set(kinds) == {"number"}:
        with suppress(ValueError):  # then what is wrong is looked for line by line
            return kinds, _numbers(rows, delimiter, line.endswith(delimiter or " "), len(cells)), {}
    first_day = min((_day(cell) for cell, kind in zip(cells, kinds) if kind in ("date", "stamp")), default=0)
    values, empty = array("d"), dict[int, int]()
    for line in rows:
        cells = _texts(line, delimiter)
        if len(cells) != len(kinds):
            raise FileError(
                path,
                f"line {rows.numbers[-1]} has {len(cells)} values and line {rows.numbers[0]} has {len(kinds)}; repair the line",
            )
        for j, cell in enumerate(cells):
            if not cell:
                values.append(np.nan)
                empty.setdefault(j, rows.numbers[-1])
                continue
            try:
                text = cell if delimiter == "," else cell.replace(",", ".")
                values.append(float(text) if kinds[j] == "number" else _seconds(text, kinds[j], first_day))
            except ValueError:
                raise FileError(
                    path,
                    f"line {rows.numbers[-1]}: {cell[:40]!r} is not {KIND_NAMES[kinds[j]]}; repair or cut out the line",
                ) from None
    return kinds, np.array(values).reshape(-1, len(kinds)), empty


def _numbers(rows: _Rows, delimiter: str | None, ends_with_delimiter: bool, width: int) -> Array:
    """The values of rows that hold numbers alone; ValueError where one of them does not, or has another width."""
    lines: Iterable[str] = rows
    if ends_with_delimiter and delimiter:  # a delimiter at the end of each line, as spreadsheets leave it
        if any(not line.endswith(delimiter) for line in rows):
            raise ValueError
        lines = (line[:-1] for line in rows)
    if delimiter != ",":
        lines = (line.replace(",", ".") for line in lines)
    values = np.loadtxt(lines, delimiter=delimiter, comments=None, ndmin=2)
    if values.shape[1] != width:
        raise ValueError
    return values


def _day(text: str) -> int:
    """The number of the day that a date or a stamp begins with; 0 where there is no such day, which `_seconds` refuses."""
    match = re.match(DAY, text)
    try:
        return date(*(int(part) for part in match.groups())).toordinal() if match else 0
    except ValueError:
        return 0


def _seconds(text: str, kind: str, first_day: int) -> float:
    """s since midnight, of dates and stamps since that before the first one; :class:`ValueError` for anything else."""
    match = KINDS[kind].fullmatch(text)
    if match is None:
        raise ValueError(text)
    parts = list(match.groups())
    seconds = 0.0
    if kind != "clock":
        # days since the first row and not since the calendar's first: s of two thousand years have no microseconds left
        seconds = 86400.0 * (date(*(int(part) for part in parts[:3])).toordinal() - first_day)
        parts = parts[3:]
    if kind != "date":
        hour, minute, second = int(parts[0]), int(parts[1]), float(parts[2])
        if hour > 23 or minute > 59 or second >= 61.0:  # 60: a leap second
            raise ValueError(text)
        seconds += 3600.0 * hour + 60.0 * minute + second
    if kind == "stamp" and parts[3] not in (None, "Z"):
        zone = parts[3].replace(":", "")
        seconds -= (1 if zone[0] == "+" else -1) * (3600.0 * int(zone[1:3]) + 60.0 * int(zone[3:5]))
    return seconds
