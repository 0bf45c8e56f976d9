"""From one ``[[step]]`` to its tests: lists make a grid, ``zip = true`` takes them row by row, ``rows`` names a table."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, get_origin, get_type_hints

from dampyr.config import split
from dampyr.errors import FileError, InputError, MissingData

Row = dict[str, Any]
MAX_TABLE = 4 * 2**20  # bytes of a table of rows: 2000 rows of 2 kB, where a row has some 50


def expanded(table: Mapping[str, Any], cls: Any, where: str, zipped: bool, rows: Sequence[Row]) -> list[Row]:
    """The fields of each test, in order: a grid's first list changes slowest, and a table's rows slowest of all."""
    axes = {name: value for name, value in table.items() if _is_axis(cls, name, value)}
    for name, values in axes.items():
        if not values:
            raise InputError(f"{where}.{name} = [] is empty; give at least one value")
    single = {name: value for name, value in table.items() if name not in axes}
    value_rows = _zip_lists(axes, where) if zipped else product(*axes.values())
    combinations = [dict(zip(axes, values)) for values in value_rows]
    for name in rows[0] if rows else ():
        if name in table:
            raise InputError(f"{where}.{name} stands in the step and in its table of rows; give it in one place")
    return [{**row, **single, **combination} for row in rows or [{}] for combination in combinations]


def count_rows(table: Mapping[str, Any], cls: Any, zipped: bool, rows: Sequence[Row]) -> tuple[int, list[str]]:
    """The number of tests that `expanded` makes, and the factors of it in words, without building one."""
    lengths = {name: len(value) for name, value in table.items() if _is_axis(cls, name, value)}
    number = max(lengths.values(), default=1) if zipped else prod(lengths.values())
    factors = [f"{n:,} values of {name}" for name, n in lengths.items()]
    if zipped:
        factors = [f"{number:,} rows of {', '.join(lengths)}"]
    if rows:
        factors, number = [f"{len(rows):,} rows of the table", *factors], number * len(rows)
    return number, factors


def _is_axis(cls: Any, name: str, value: Any) -> bool:
    hint = split(get_type_hints(cls, include_extras=True).get(name))[0]
    if get_origin(hint) is tuple:
        return isinstance(value, list) and bool(value) and all(isinstance(item, list) for item in value)
    return isinstance(value, list)


def _zip_lists(axes: Mapping[str, Sequence[Any]], where: str) -> Sequence[Sequence[Any]]:
    lengths = {name: len(values) for name, values in axes.items()}
    if len(set(lengths.values())) > 1:
        summary = ", ".join(f"{name} has {n}" for name, n in lengths.items())
        raise InputError(f"{where}: zip = true takes lists row by row, and {summary}; give as many of each")
    if not axes:
        raise InputError(f"{where}: zip = true takes lists row by row, and there is no list; leave it out")
    return list(zip(*axes.values(), strict=True))


def read_rows(path: Path) -> list[Row]:
    """The rows of a CSV table whose header names fields, such as ``peak_to_peak [mm],frequency [Hz],voltage [V]``."""
    try:
        if (size := path.stat().st_size) > MAX_TABLE:
            raise FileError(
                path, f"has {size / 2**20:.0f} MiB; a table of rows has at most {MAX_TABLE // 2**20}; shorten it"
            )
        lines = list(csv.reader(path.read_text("utf-8-sig").splitlines()))
    except FileNotFoundError:
        raise MissingData(f"{path}: there is no such file; check rows in the campaign") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise FileError(path, f"cannot be read ({problem})") from None
    filled = [(k + 1, line) for k, line in enumerate(lines) if any(cell.strip() for cell in line)]
    if len(filled) < 2:
        raise FileError(path, "has no rows; give a header and at least one row")
    heads = [_split_heading(cell) for cell in filled[0][1]]
    for number, line in filled[1:]:
        if len(line) != len(heads):
            raise FileError(path, f"line {number} has {len(line)} cells, the header {len(heads)}")
    return [{name: _cell_value(cell, unit) for (name, unit), cell in zip(heads, line)} for _, line in filled[1:]]


def _split_heading(cell: str) -> tuple[str, str]:
    name, _, unit = cell.strip().partition("[")
    return name.strip(), unit.rstrip("]").strip()


def _cell_value(cell: str, unit: str) -> Any:
    text = cell.strip()
    if unit:
        return f"{text} {unit}"
    for number in (int, float):
        try:
            return number(text)
        except ValueError:
            continue
    return text
