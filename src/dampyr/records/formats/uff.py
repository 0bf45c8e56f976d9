"""Universal files (UFF, SDRC): each dataset 58 or 58b, ASCII or binary, that is a function of time is a column.

The name is the label of the ordinate or, where that does not tell the columns apart, the first line of text; the type of the
ordinate (displacement, velocity, force, temperature) goes before names. The unit is that of the label, else that of a dataset
164 with one of the systems of units of the format. Functions of something else, such as spectra, are left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.channel_columns import OF_TEXTS, Array, ColumnTable
from dampyr.errors import FileError, one_line
from dampyr.phrases import counted
from dampyr.records.files.column_table import record_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

TITLE = "universal file"
DELIMITER = b"-1"  # alone on a line, before and after each dataset
HEADER = 11  # lines of text of a dataset 58 above its values
TIME = 17  # type of an abscissa
KINDS = {8: "displacement", 11: "velocity", 9: "force", 13: "force", 5: "temperature"}
"""Types of an ordinate that are channels of a record."""
SYSTEMS = {1: ("m", "N"), 2: ("ft", "lbf"), 5: ("mm", "mN"), 6: ("cm", "cN"), 7: ("in", "lbf"), 10: ("mm", "N")}
"""Length and force by the code of a dataset 164."""
REPAIR = "export the file again"


@dataclass(frozen=True)
class TimeFunction:
    """A dataset 58: its place in the file, the numbers of its header and its values."""

    line: int  # of its "58", from 1
    title: str
    label: str
    unit: str
    kind: int
    abscissa: int
    abscissa_unit: str
    times: Array
    values: Array


def read(path: Path, request: ReadOptions) -> Record:
    """The record in the functions of time of a ``.uff`` file, in SI."""
    reason = "a universal file names its functions"
    request.refuse(path, variable=reason, **dict.fromkeys(OF_TEXTS, reason))
    system: tuple[str, str] | None = None
    functions, others = list[TimeFunction](), 0
    for number, kind, lines, binary in _datasets(path, path.read_bytes()):
        if kind == "164":
            system = SYSTEMS.get(int(lines[0][:10] or 0)) if lines and lines[0][:10].strip().isdigit() else None
        elif kind in ("58", "58b"):
            try:
                function = _function(path, number, lines, binary if kind == "58b" else None)
            except FileError:
                raise
            except (ValueError, IndexError) as problem:
                raise FileError(
                    path, f"line {number}: this dataset 58 cannot be read ({one_line(problem)}); {REPAIR}"
                ) from problem
            if function is None or function.abscissa not in (TIME, 0):
                others += 1
            else:
                functions.append(function)
    if not functions:
        left_out = f" but {counted(others, 'function')} of something else than time" if others else ""
        raise FileError(
            path, f"has no dataset 58 that is a real function of time{left_out}; {REPAIR} with time histories"
        )
    first = functions[0]
    for function in functions[1:]:
        if len(function.times) != len(first.times) or not np.allclose(
            function.times, first.times, rtol=0, atol=1e-6 * float(np.ptp(first.times) / len(first.times))
        ):
            raise FileError(
                path,
                f"the functions at lines {first.line} and {function.line} have different times "
                f"({len(first.times)} and {len(function.times)} samples); export them on one time",
            )
    kinds = [KINDS.get(function.kind, "") for function in functions]
    by_kind = {kind: 1 + k for k, kind in enumerate(kinds) if kind and kinds.count(kind) == 1}
    notes = [f"channels by their types in the file: {', '.join(by_kind)}"] if by_kind else []
    notes += [f"{counted(others, 'function')} of something else than time left out"] if others else []
    table = ColumnTable(
        names=("time", *_names(functions)),
        units=(first.abscissa_unit or "s", *(function.unit or _unit(function.kind, system) for function in functions)),
        values=np.column_stack([first.times, *(function.values for function in functions)]),
        notes=tuple(notes),
    )
    return record_of(path, table, replace(request, columns={**by_kind, **request.columns}), TITLE)


def _datasets(path: Path, content: bytes) -> Iterator[tuple[int, str, list[str], tuple[str, bytes]]]:
    """Line of its number, number, lines and, of a 58b, byte order and values of each dataset in the file."""
    position, line = 0, 0

    def next_line() -> bytes:
        nonlocal position, line
        end = content.find(b"\n", position)
        end = len(content) if end < 0 else end
        text, position, line = content[position:end].rstrip(b"\r"), end + 1, line + 1
        return text

    while position < len(content):
        if next_line().strip() != DELIMITER:
            continue
        head = next_line().decode("latin-1")
        match = re.match(r"\s*(\d+)\s*(b?)", head, re.IGNORECASE)
        if match is None:
            raise FileError(path, f"line {line}: {head[:40]!r} is not the number of a dataset; {REPAIR}")
        kind, number, lines = match[1] + match[2].lower(), line, list[str]()
        values = ("<", b"")
        if kind == "58b":
            order, floats, count, size = (int(word or 0) for word in re.findall(r"\d+", head[match.end() :])[:4])
            if floats != 2 or order not in (1, 2):
                raise FileError(path, f"line {line}: its values are not those of IEEE 754; {REPAIR} so, or as ASCII")
            lines = [next_line().decode("latin-1") for _ in range(count)]
            values = ("<" if order == 1 else ">", content[position : position + size])
            position += size
            if len(values[1]) < size:
                raise FileError(
                    path, f"line {number}: {size} bytes should follow and {len(values[1])} do; it was cut, so {REPAIR}"
                )
        closed = False
        while position < len(content) and not closed:
            text = next_line()
            closed = text.strip() == DELIMITER
            if not closed and kind != "58b":
                lines.append(text.decode("latin-1"))
        if not closed:
            raise FileError(path, f"line {number}: the dataset {kind} has no end, -1; the file was cut, so {REPAIR}")
        yield number, kind, lines, values


def _function(path: Path, line: int, lines: list[str], binary: tuple[str, bytes] | None) -> TimeFunction | None:
    """The function of a dataset 58; None where its values are complex."""
    numbers = lines[6]
    of_values, count, spacing = (int(numbers[k : k + 10]) for k in (0, 10, 20))
    start, step = (float(numbers[k : k + 13].replace("D", "E")) for k in (30, 43))
    if of_values not in (2, 4):
        return None
    width = 13 if of_values == 2 else 20
    even = spacing == 1
    if binary is not None:
        order, content = binary
        size = 4 if of_values == 2 else 8
        values: Any = (
            np.frombuffer(content, np.dtype([("x", f"{order}f4"), ("y", f"{order}f8")])).copy()
            if not even
            and size == 8
            and len(content) == 12 * count  # times of single precision beside values of double
            else np.frombuffer(content, f"{order}f{size}").astype(np.float64)
        )
        pairs: Array = np.column_stack([values["x"], values["y"]]).ravel() if values.dtype.names else values
    else:
        widths = (width,) if even else (13, width)
        pairs = np.array(
            [
                value
                for k, text in enumerate(lines[HEADER:])
                for value in _cut(path, line + 1 + HEADER + k, text, widths)
            ]
        )
    wanted = count if even else 2 * count
    if len(pairs) != wanted or count < 1:
        raise FileError(
            path,
            f"line {line}: the header says {wanted} numbers and {len(pairs)} follow; the file was cut, so {REPAIR}",
        )
    times: Array
    values_of: Array
    times, values_of = (
        (start + step * np.arange(count, dtype=np.float64), pairs) if even else (pairs[0::2], pairs[1::2])
    )
    (abscissa, _, abscissa_unit), (kind, label, unit) = _axis(lines[7]), _axis(lines[8])
    return TimeFunction(line, _word(lines[0]), label, unit, kind, abscissa, abscissa_unit, times, values_of)


def _cut(path: Path, line: int, text: str, widths: tuple[int, ...]) -> Iterator[float]:
    """The numbers of a line in fields of these widths, in turn."""
    position, k = 0, 0
    while position < len(text.rstrip()):
        field = text[position : position + widths[k % len(widths)]]
        try:
            yield float(field.replace("D", "E").replace("d", "e"))
        except ValueError:
            raise FileError(path, f"line {line}: {field!r} is not a number; {REPAIR}") from None
        position, k = position + widths[k % len(widths)], k + 1


def _axis(text: str) -> tuple[int, str, str]:
    """Type, label and unit of an axis, ``2(I10,3I5,2(1X,20A1))``."""
    return int(text[:10]), _word(text[26:46]), _word(text[47:67])


def _word(text: str) -> str:
    """A text, empty where the file says that there is none."""
    return "" if text.strip().upper() == "NONE" else text.strip()


def _names(functions: list[TimeFunction]) -> list[str]:
    """Labels, or the first lines of text, whichever tell all of them apart; else both."""
    for names in ([each.label for each in functions], [each.title for each in functions]):
        if all(names) and len(set(names)) == len(names):
            return names
    return [f"{each.title} {each.label}".strip() or f"function at line {each.line}" for each in functions]


def _unit(kind: int, system: tuple[str, str] | None) -> str:
    if system is None:
        return ""
    length, force = system
    return {"displacement": length, "velocity": f"{length}/s", "force": force}.get(KINDS.get(kind, ""), "")
