"""Tables of numbers in a text, of records and ground motions: how they are written is recognised, and the notes say how.

A header cell is a name and a unit in brackets or parentheses: ``time [s]``, ``force (N)``; a line of units may follow the
names. Lines that start with ``#`` or ``%`` are comments; the last line before the numbers is the header, even as a comment.
The delimiter is a semicolon, a tab, a comma or white space; cells may stand in quotes. A comma is the decimal mark in a quoted
cell and where it is not the delimiter. A point or a comma before groups of three digits, beside the other mark or twice in a
number, is a thousands mark; where it could be either, the text is refused until that is declared. Fields of one width may
touch. An exponent may be a D. A text that is not UTF-8 is read as Latin-1. A column may hold times of day (``10:00:00.123``),
dates (``2026-03-01``) or both (``2026-03-01T10:00:00.123``).
"""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.channel_columns import NAMES, Array, ColumnTable, TextOptions, name_and_unit, plain_name
from dampyr.errors import FileError
from dampyr.units import UNIT_WORDS

MAX_COLUMNS = 1000  # of a line: a test has some ten channels; a file with more is written the wrong way round
MAX_ABOVE = 10_000  # lines above the numbers: a text that has more is none of numbers
FEW = 5  # rows of which most have the delimiter: the first may be the one that is wrong
SAMPLE = 1000  # rows by which the delimiter is told from a decimal comma
LARGE = 4_000_000  # characters of numbers from which on pandas reads them: it is three times as fast, and takes 0.5 s to load
EXACT = (3, 1)  # version of pandas from which on it reads every number exactly without being asked to
DELIMITERS = (";", "\t", ",")
DAY = r"(\d{4})[-/](\d{1,2})[-/](\d{1,2})"
CLOCK = r"(\d{1,2}):(\d{2}):(\d{2}(?:\.\d*)?)"
DECIMAL_COMMA = rf"[+-]?\d+(,\d+)?([eEdD][+-]?\d+)?|{DAY}|\d{{1,2}}:\d{{2}}:\d{{2}}(,\d*)?"
GROUPED_BY_COMMAS = r"[+-]?(\d{1,3}(,\d{3})+|\d*)(\.\d*)?"
KINDS = {
    "clock": re.compile(CLOCK),
    "date": re.compile(DAY),
    "stamp": re.compile(rf"{DAY}(?:T|\s+){CLOCK}\s*(Z|[+-]\d{{2}}:?\d{{2}})?"),
}
"""What a cell may be besides a number."""
KIND_NAMES = {"number": "a number", "clock": "a time of day", "date": "a date", "stamp": "a date with a time of day"}
FORTRAN = re.compile(r"([+-]?\d*\.?\d*)[dD]([+-]?\d+)")
BLANK_LINE = re.compile(r"\n[ \t]*(?=\n|$)")
TOUCHING = re.compile(
    r"(?:[+-]?\d*[.]\d*(?:[eEdD][+-]?\d{1,2})?){2,}"
)  # fields of one width without blanks between them
BOTH_MARKS = re.compile(r"(?<![\d.,])\d{1,3}(?:\.\d{3})+,\d|(?<![\d.,])\d{1,3}(?:,\d{3})+\.\d")
TWICE = re.compile(r"(?<![\d.,])\d{1,3}([.,])\d{3}\1\d{3}(?!\d)")
NO_GROUP = r"(?<![\d.,])0?{0}\d|{0}(?!\d{{3}}(?!\d))|\d{{4}}{0}"  # beside a mark, what a thousands mark does not have


def read_table(
    path: Path,
    request: TextOptions,
    *,
    by_number: bool = False,
    least: int = 2,
    series: bool = False,
    comment: re.Pattern[str] | None = None,
) -> ColumnTable:
    """The numbers of a text file with the header above them.

    Parameters
    ----------
    path, request
        The file, and what is declared of it: ``header``, ``thousands``, ``encoding`` and ``delimiter`` count here.
    by_number
        No name is needed, so that a header which does not fit the columns is left out.
    least
        How many numbers a line has at least that is one of numbers.
    series
        The last row may be short: its rows are pieces of one series.
    comment
        A line of comment that is no header.
    """
    text, note = decoded(path, request.encoding)
    return table_of_text(path, text, request, by_number, least, series, comment, (note,) if note else ())


def table_of_text(
    path: Path,
    text: str,
    request: TextOptions,
    by_number: bool = False,
    least: int = 2,
    series: bool = False,
    comment: re.Pattern[str] | None = None,
    notes: tuple[str, ...] = (),
) -> ColumnTable:
    """As `read_table`, of a text that came from ``path``; ``notes`` go to the record's history."""
    lines, first, begin = _first_row(path, text, request.header, least, request.mark)
    table = table_of_rows(path, text[begin:], first, request, series, least)
    width, above = table.values.shape[1], lines[:first]
    cells = (
        [] if request.header == 0 else _header(path, above, request.header, table.delimiter, width, by_number, comment)
    )
    pairs = [name_and_unit(cell) for cell in cells]
    return replace(
        table,
        names=tuple(name for name, _ in pairs),
        units=tuple(unit for _, unit in pairs),
        above=tuple(above),
        notes=(*notes, *table.notes),
    )


def decoded(path: Path, encoding: str | None = None) -> tuple[str, str]:
    """The text of a file with \\n at the end of each line, and what the history says where it is no UTF-8."""
    content, note = path.read_bytes(), ""
    text = None
    if encoding is not None:
        try:
            text, note = content.decode(encoding).removeprefix("\ufeff"), f"read as {encoding} text, as declared"
        except UnicodeDecodeError as problem:
            raise FileError(
                path, f"is not {encoding} text (byte {problem.start}); correct the encoding, or leave it out"
            ) from None
    elif content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        with suppress(UnicodeDecodeError):
            text, note = content.decode("utf-16"), "read as UTF-16 text"
    if text is None:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as problem:
            if b"\0" in content:
                raise FileError(path, f"is not a text (byte {problem.start}); choose a text file") from None
            text, note = (
                content.decode("cp1252", errors="replace"),
                "read as Latin-1 (Windows-1252) text, as it is not UTF-8",
            )
    if "\r" in text:  # a file that was sent as a text twice has CR CR LF
        text = re.sub(r"\r+\n", "\n", text).replace("\r", "\n")
    return text, note


def has_numbers(path: Path, request: TextOptions) -> bool:
    """Whether a text file has a line of two or more numbers, and nothing else but times, as every record has.

    A file with a line of too many columns counts as a record, so that reading it says what is wrong with it.
    """
    lines = decoded(path, request.encoding)[0].split("\n")[: (request.header or 0) + MAX_ABOVE]
    return any(_is_too_wide(line) or _is_row(line, 2, request.mark) for line in lines)


def _is_too_wide(line: str) -> bool:
    return len(line) > MAX_COLUMNS and max(map(line.count, ",;\t ")) > MAX_COLUMNS


def _first_row(
    path: Path, text: str, header: int | None, least: int, declared: str | None
) -> tuple[list[str], int, int]:
    """The lines up to the first of numbers, how many stand above the numbers, and where in the text these begin.

    A line right above them with something else in a place of a number counts with them.
    """
    start, end, lines = header or 0, -1, list[str]()
    while end < len(text):
        begin, end = end + 1, text.find("\n", end + 1) % (len(text) + 1)  # of the last line the end of the text
        lines.append(text[begin:end])
        if _is_too_wide(lines[-1]):
            raise FileError(
                path,
                f"line {len(lines)} has more than {MAX_COLUMNS} columns, a record has a line for each sample; "
                "write it so, or leave out columns",
            )
        if len(lines) > start and _is_row(lines[-1], least, declared):
            break
        if len(lines) > start + MAX_ABOVE:
            raise FileError(
                path,
                f"has no line of numbers among {MAX_ABOVE:,} lines{f' below line {start}' if start else ''}; say on which line "
                "the names stand, --header 7 or header=7, or cut out what stands above them",
            )
    else:
        count = len(lines) - (not lines[-1])
        if header is not None and header >= max(count, 1):
            raise FileError(
                path, f"header = {header}, but the file has {count} lines; give the line of the names, from 1"
            )
        parted = f" parted by {declared!r}, as declared" if declared else ""
        raise FileError(path, f"has no line of numbers{parted}; give a header and one line per sample")
    first = len(lines) - 1
    delimiter = _delimiter(lines[first], declared)
    width = len(_cells(lines[first], delimiter))
    for k in range(first - 1, start - 1, -1):
        cells = _cells(lines[k], delimiter)
        if not lines[k].strip() or len(cells) != width or _kind(cells[0], delimiter) in (None, "empty"):
            break
        first, begin = k, begin - len(lines[k]) - 1
    return lines, first, begin


def _is_row(line: str, least: int, declared: str | None) -> bool:
    """Whether a line is so many numbers, with times and dates between them or without."""
    text = line.strip()
    if not text or text[0] in "#%":
        return False
    delimiter = _delimiter(line, declared)
    kinds = [_kind(cell, delimiter) for cell in _cells(line, delimiter)]
    return None not in kinds and kinds.count("number") + 2 * kinds.count("touching") >= least


def _delimiter(line: str, declared: str | None) -> str | None:
    """What parts a line of numbers: as declared, or the first delimiter outside of quotes; None is white space."""
    if declared is not None:
        return None if declared == " " else declared
    plain = re.sub(r'"[^"]*"', "0", line) if '"' in line else line
    delimiter = next((mark for mark in DELIMITERS if mark in plain.strip()), None)
    parts = plain.split()
    # a comma inside columns of white space, such as 0,01  1,5 or 0.01  1,507.964, is a mark
    if delimiter == "," and len(parts) > 1:
        marked = (all(re.fullmatch(number, part) for part in parts) for number in (DECIMAL_COMMA, GROUPED_BY_COMMAS))
        return None if any(marked) else delimiter
    return delimiter


def _cells(line: str, delimiter: str | None) -> list[str]:
    """The cells of a line without quotes; a delimiter at its end, as spreadsheets leave it, makes none."""
    bare = line.strip(" ") if delimiter == "\t" else line.strip()
    if not bare.strip():
        return []
    cells = bare.split(delimiter) if delimiter else bare.split()
    if '"' in bare:
        with suppress(csv.Error):
            cells = next(csv.reader([bare], delimiter=delimiter or " ", skipinitialspace=True))
    cells = cells[:-1] if len(cells) > 1 and not cells[-1].strip() else cells
    return [cell.strip().strip('"') for cell in cells]


def _row(line: str, delimiter: str | None, width: int) -> list[str]:
    """As `_cells`; where the delimiter at the end stands before the last of ``width`` cells, that one is empty."""
    cells = _cells(line, delimiter)
    ends = delimiter is not None and line.rstrip(" ").endswith(delimiter)
    return [*cells, ""] if ends and len(cells) == width - 1 else cells


def _kind(cell: str, delimiter: str | None) -> str | None:
    """What a cell is, whatever its marks: "number", "clock", "date", "stamp", "touching" fields, "empty", or None."""
    if not cell:
        return "empty"
    text = cell.replace(",", ".")
    with suppress(ValueError):
        float(text if text.count(".") < 2 else re.sub(r"[.' ](?=\d{3}(?!\d))", "", text))
        return "number"
    if FORTRAN.fullmatch(text):
        return "number"
    if delimiter is None and TOUCHING.fullmatch(cell):
        return "touching"
    return next((kind for kind, pattern in KINDS.items() if pattern.fullmatch(text)), None)


def table_of_rows(
    path: Path,
    text: str,
    first: int,
    request: TextOptions,
    series: bool = False,
    least: int = 2,
) -> ColumnTable:
    """The numbers of a text whose first line is number ``first`` (from 0) of the file.

    Blank lines and comments are left out.
    """
    text = text.rstrip(" \n")
    characters = np.frombuffer(text.encode(), dtype=np.uint8)
    ends = np.flatnonzero(characters == ord("\n"))
    numbers: Sequence[int] = range(first + 1, first + 2 + len(ends))
    indented = len(ends) and np.any(characters[ends + 1] <= ord(" "))
    if "#" in text or "%" in text or (indented and BLANK_LINE.search(text)):
        kept = [(k, row) for k, row in zip(numbers, text.split("\n")) if (bare := row.strip()) and bare[0] not in "#%"]
        numbers, text = [k for k, _ in kept], "\n".join(row for _, row in kept)
    rows = text.split("\n", SAMPLE)[:SAMPLE]
    delimiter = Counter(_delimiter(row, request.mark) for row in rows[:FEW]).most_common(1)[0][0]
    if least == 1 and request.mark is None and delimiter == "," and _is_decimal_column(rows):
        delimiter = None  # one column: 0,0005 is no time and acceleration
    cells = _cells(rows[0], delimiter)
    kinds = tuple(kind if kind in KINDS else "number" for kind in (_kind(cell, delimiter) for cell in cells))
    stamps = {k: cells[k] for k, kind in enumerate(kinds) if kind != "number"}
    quoted, whole = '"' in text, text
    rest: list[str] = []
    if series and len(_cells(text[text.rfind("\n") + 1 :], delimiter)) < len(cells):
        text, _, last = text.rpartition("\n")
        rest = _cells(last, delimiter)
    decimal, thousands = _marks(path, text, numbers, delimiter, quoted, request.thousands)
    values, empty, count = None, dict[int, int](), len(numbers) - bool(rest)
    if not (stamps or thousands or any(map(TOUCHING.fullmatch, rest))):
        values = _numbers(text, delimiter, decimal, quoted, count, len(cells))
    notes = ("decimal commas",) * (decimal == ",")
    if values is None:
        if not thousands and (delimiter != "," or quoted) and (twice := _twice(text)):
            decimal, thousands = twice
        notes = ("decimal commas",) * (decimal == ",") + (f"thousands marks {thousands!r} left out",) * bool(thousands)
        parted = [_row(row, delimiter, len(cells)) for row in text.split("\n")]
        if delimiter is None and any(TOUCHING.fullmatch(cell) for row in parted for cell in row):
            parted, field_width = _fixed_width(path, whole.split("\n"), numbers)
            kinds, notes = ("number",) * len(parted[0]), (*notes, f"fields of {field_width} characters")
            rest = parted.pop() if series and len(parted[-1]) < len(kinds) else []
        values, empty = _cell_by_cell(path, parted, numbers, kinds, decimal, thousands)
    short = len(kinds) - len(rest) if rest else 0
    if rest:
        ending, _ = _cell_by_cell(path, [rest], numbers[-1:], kinds[: len(rest)], decimal, thousands)
        values = np.vstack([values, np.r_[ending[0], np.full(short, np.nan)]])
    return ColumnTable(
        (), (), values, kinds, stamps, lines=numbers, empty=empty, short=short, notes=notes, delimiter=delimiter
    )


def _is_decimal_column(rows: list[str]) -> bool:
    """Whether rows such as 1,0005 are one column with decimal commas: whole numbers alone, of which a second begins with 0."""
    pairs = [re.fullmatch(r"\s*[+-]?\d+,(\d+)(?:[eE][+-]?\d+)?\s*", row) for row in rows]
    return all(pairs) and any(len(pair[1]) > 1 and pair[1][0] == "0" for pair in pairs if pair)


def _marks(
    path: Path, text: str, numbers: Sequence[int], delimiter: str | None, quoted: bool, declared: str | None
) -> tuple[str, str]:
    """The decimal mark and the mark between thousands, "" where there is none."""
    if declared is not None:
        other = {",": ".", ".": ","}.get(declared, "," if "," in text and delimiter != "," else ".")
        if delimiter == "," and not quoted and "," in (declared, other):
            raise FileError(path, f"thousands = {declared!r} was given, but commas part the columns; leave it out")
        return other, declared if declared in text else ""
    if delimiter == "," and not quoted:
        return ".", ""
    has_comma, has_point = _has(text, ",", delimiter), _has(text, ".", delimiter)
    if has_comma and has_point and (match := BOTH_MARKS.search(text)):
        decimal = "," if match[0].rfind(",") > match[0].rfind(".") else "."
        return decimal, "," if decimal == "." else "."
    if has_comma and has_point:  # of the stamps, or a line that is wrong: the mark of most numbers is the decimal one
        commas, points = (len(re.findall(rf"(?<!:\d\d){mark}\d", text)) for mark in (",", r"\."))
        return ("," if commas > points else "."), ""
    mark = "," if has_comma else "." if has_point and (delimiter == ";" or quoted) else ""
    if mark and not re.search(NO_GROUP.format(re.escape(mark)), text):
        if twice := _twice(text):
            return twice
        if match := re.search(rf"\d+{re.escape(mark)}\d+", text):
            line = numbers[text.count("\n", 0, match.start())]
            value = match[0].replace(mark, ".")
            raise FileError(
                path,
                f"line {line}: {match[0]!r} may be {match[0].replace(mark, '')} or {value}; say which mark stands between "
                f"thousands, --thousands {mark} or --thousands {'.' if mark == ',' else ','} (thousands= in Python)",
            )
    return ("," if has_comma else "."), ""


def _twice(text: str) -> tuple[str, str] | None:
    """The decimal mark and the mark between thousands, by a number in which the latter stands twice; None without one."""
    match = TWICE.search(text)
    return None if match is None else ("." if match[1] == "," else ",", match[1])


def _has(text: str, mark: str, delimiter: str | None) -> bool:
    """Whether a mark stands in numbers: a delimiter does so between digits in quotes alone."""
    return mark in text if mark != delimiter else bool(re.search(rf'"[^"\n{mark}]*\d{mark}\d[^"\n{mark}]*"', text))


def _numbers(text: str, delimiter: str | None, decimal: str, quoted: bool, rows: int, width: int) -> Array | None:
    """The values ``(rows, width)`` of a text of plain numbers; None where it is something else."""
    if quoted:
        if delimiter is None:
            return None
        text, delimiter = re.sub(rf'"[ ]*{re.escape(delimiter)}[ ]*"', "\t", text).replace('"', ""), "\t"
        if decimal == "." and "," in text:
            return None
    if delimiter and text.endswith(delimiter):  # at the end of each line, as spreadsheets leave it
        if text.count(f"{delimiter}\n") + 1 != rows:
            return None
        text = text.replace(f"{delimiter}\n", "\n").removesuffix(delimiter)
    if decimal == ",":
        if "." in text:
            return None
        text = text.replace(",", ".")
    elif delimiter != "," and "," in text:
        return None
    try:
        if len(text) < LARGE:
            values = np.loadtxt(text.split("\n"), delimiter=delimiter, comments=None, ndmin=2)
        else:
            values = _by_pandas(text, delimiter)
    except ValueError:  # then what is wrong is looked for line by line
        return None
    return values if values.shape == (rows, width) else None


def _by_pandas(text: str, delimiter: str | None) -> Array:
    import pandas

    version = tuple(int(part) for part in re.findall(r"\d+", pandas.__version__)[:2])
    exactly: dict[str, Any] = {} if version >= EXACT else {"float_precision": "round_trip"}
    frame = pandas.read_csv(
        io.BytesIO(text.encode()), sep=delimiter or r"\s+", header=None, dtype=np.float64, na_filter=False, **exactly
    )
    values = frame.to_numpy()
    if np.isnan(values).any():  # a row that is short, which pandas fills
        raise ValueError
    return values


def _fixed_width(path: Path, rows: list[str], numbers: Sequence[int]) -> tuple[list[list[str]], int]:
    """The cells of rows whose fields of one width touch, and that width: the ends of all fields are multiples of it."""
    ends = math.gcd(*(match.end() for row in rows for match in re.finditer(r"\S+", row)))
    for width in (width for width in range(ends, 2, -1) if ends % width == 0):
        cells = [[row[k : k + width].strip() for k in range(0, len(row.rstrip()), width)] for row in rows]
        if all(_kind(cell, ",") == "number" for row in cells for cell in row):
            return cells, width
    k = next(k for k, row in enumerate(rows) if any(TOUCHING.fullmatch(cell) for cell in row.split()))
    raise FileError(
        path,
        f"line {numbers[k]} is {rows[k].strip()[:60]!r}: numbers touch, and no width of a field parts all lines into numbers; "
        "part them by blanks",
    )


def _cell_by_cell(
    path: Path, rows: list[list[str]], numbers: Sequence[int], kinds: tuple[str, ...], decimal: str, thousands: str
) -> tuple[Array, dict[int, int]]:
    """The values ``(n, m)`` as numbers or s, and the line of the first empty cell of each column, which is NaN: a column that
    says something once, in the first row, may be left out of a record.
    """
    mark, group = re.escape(decimal), re.escape(thousands)
    grouped = re.compile(rf"[+-]?(?:\d{{1,3}}(?:{group}\d{{3}})+|\d*)(?:{mark}\d*)?(?:[eE][+-]?\d+)?")
    other = "," if decimal == "." else "."
    first_day, values, empty, row_count = 0, [], dict[int, int](), 0
    for cells in rows:
        line = numbers[row_count]
        if len(cells) != len(kinds):
            raise FileError(
                path, f"line {line} has {len(cells)} values and line {numbers[0]} has {len(kinds)}; repair the line"
            )
        if row_count == 0:
            first_day = min((_day(cell) for cell, kind in zip(cells, kinds) if kind in ("date", "stamp")), default=0)
        row_count += 1
        for j, cell in enumerate(cells):
            if not cell:
                values.append(math.nan)
                empty.setdefault(j, line)
                continue
            try:
                if kinds[j] != "number":
                    values.append(_seconds(cell.replace(",", "."), kinds[j], first_day))
                    continue
                if thousands and thousands in cell:
                    if not grouped.fullmatch(cell):
                        raise ValueError
                    cell = cell.replace(thousands, "")
                if other in cell or "_" in cell:
                    raise ValueError
                text = cell.replace(",", ".")
                values.append(float(FORTRAN.sub(r"\1E\2", text) if "d" in text or "D" in text else text))
            except ValueError:
                marks = ""
                if other in cell and re.fullmatch(r"[+-]?[\d.,]+(?:[eE][+-]?\d+)?", cell):
                    marks = f": the decimal mark is a {'comma' if decimal == ',' else 'point'} in the other lines"
                raise FileError(
                    path, f"line {line}: {cell[:40]!r} is not {KIND_NAMES[kinds[j]]}{marks}; repair or cut out the line"
                ) from None
    return np.array(values, dtype=float).reshape(-1, len(kinds)), empty


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


def _header(
    path: Path,
    above: list[str],
    line: int | None,
    delimiter: str | None,
    width: int,
    by_number: bool,
    comment: re.Pattern[str] | None,
) -> list[str]:
    """The cells of the header, each name with its unit; none where there is no header."""
    texts = [text.strip().lstrip("#% ") for text in above]
    if line is None:
        # the names, and what may be a line of units below them
        candidates = [text for text in texts if text and not (comment and comment.fullmatch(f"# {text}"))]
        names, last = ["", "", *candidates][-2:]
    else:
        names = texts[line - 1]
        last = next((text for text in texts[line:] if text), names)
    cells = _with_units_below(_cells(names, delimiter), _cells(last, delimiter))
    if line is not None and cells == _cells(last, delimiter):
        cells = _cells(names, delimiter)
    if not cells or len(cells) == width:
        return cells
    # names that stand apart from their units in columns of white space: force (N)
    spaced = re.findall(r"[^\s\[\]()]+(?:\s*[\[(][^\])]*[\])])?", last if line is None else names)
    if len(spaced) == width:
        return spaced
    if by_number:
        return []
    commas = (
        "; decimal commas between commas want quotes or semicolons"
        if len(cells) * 2 == width and delimiter == ","
        else ""
    )
    raise FileError(
        path,
        f"the header names {len(cells)} columns and the first line has {width} numbers{commas}; repair the header, or say "
        "which line it is, from 1, or 0 where there is none: --header 0, header=0",
    )


def _with_units_below(names: list[str], cells: list[str]) -> list[str]:
    """The cells of the header; where its last line is units, each after the name above it.

    Units are cells of which all are known as such; or at least half, if more are units than names of channels: what is not
    known among them is told when its column is read.
    """
    bare = [cell.strip("[]() ") for cell in cells]
    words = [unit.lower().rstrip(".") for unit in bare]
    known = sum(word in ("", "-") or word in UNIT_WORDS for word in words)
    named = sum(any(plain_name(word) in channel for channel in NAMES.values()) for word in words)
    if len(names) != len(cells) or not (known == len(cells) or (2 * known >= len(cells) and known > named)):
        return cells
    return [f"{name} [{unit}]" if unit not in ("", "-") else name for name, unit in zip(names, bare)]
