"""Columns of numbers with names and units: which column is which channel, and each channel in the unit it is held in.

The columns come from a text (:mod:`dampyr.text_table`), a sheet, a TDMS or a MATLAB file, and belong to a record or a ground
motion: the class of the options says which channels there are.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FileError, InputError
from dampyr.options import Options, Terminal
from dampyr.phrases import listing
from dampyr.units import UNIT_WORDS, Quantity, parse, to_si

Array = NDArray[np.float64]

MAX_NAMED = 20  # columns that a message lists: a line of a page
THOUSANDS = (",", ".", "'", " ")
DELIMITERS = {",": ",", ";": ";", "tab": "\t", "\t": "\t", "|": "|", "blank": " ", " ": " "}
"""What parts columns, by how a person writes it; a blank is any white space."""
OF_TEXTS = ("header", "thousands", "encoding", "delimiter")
"""Options of texts alone: a format that holds numbers refuses them."""
NAMES = {
    "time": ("time", "t", "tempo", "timestamp", "zeit", "temps", "tiempo", "时间", "時間"),
    "displacement": (
        *("displacement", "disp", "dist", "position", "stroke", "x", "weg", "deslocamento", "desplazamiento"),
        *("deplacement", "spostamento", "位移", "変位"),
    ),
    "force": ("force", "forc", "load", "f", "kraft", "forca", "fuerza", "forza", "力", "荷重"),
    "velocity": (
        *("velocity", "speed", "v", "vel", "geschwindigkeit", "velocidade", "velocidad", "vitesse", "velocita"),
        "速度",
    ),
    "voltage": ("voltage", "u", "voltagem", "voltaje", "spannung", "tensao", "tension", "tensione"),
    "current": ("current", "i", "strom", "corrente", "corriente", "courant", "电流", "電流"),
    "temperature": ("temperature", "temp", "temperatur", "temperatura", "温度"),
    "acceleration": (
        *("acceleration", "acc", "accel", "a", "beschleunigung", "aceleracao", "aceleracion", "accelerazione"),
        "加速度",
    ),
    "extension": (
        *("extension", "extension force", "rebound", "rebound force", "zugstufe", "extensao", "detente"),
        *("estensione", "distensao"),
    ),
    "compression": (
        *("compression", "compression force", "bump", "bump force", "jounce", "jounce force"),
        *("druckstufe", "compressao", "compresion", "compressione"),
    ),
}
"""What columns are called, by the channel: without accents, in lower case."""
NAMES["speed"] = NAMES["velocity"]
ALSO_STRESS = ("spannung", "tensao", "tension", "tensione")
"""Names of a voltage that are those of a mechanical stress or a pull, too: a column in V alone is the voltage."""


@dataclass(frozen=True)
class TextOptions(Options):
    """What a caller states of files of columns, which they do not state themselves."""

    CHANNELS: ClassVar[Mapping[str, str]] = {}
    """The channels that such a file may have, each with the unit it is held in."""

    units: Annotated[
        Mapping[str, str],
        Terminal("--unit", "CHANNEL=UNIT"),
        "Units of the channels of which the files state none, such as time=ms",
    ] = field(default_factory=dict)
    columns: Annotated[
        Mapping[str, str | int | None],
        Terminal("--column", "CHANNEL=NAME"),
        "Columns of the channels, where the header's own words do not tell: force='Load cell', with its unit as in "
        "'displacement=Displacement (mm)', its number from 0, or - for none",
    ] = field(default_factory=dict)
    factors: Annotated[
        Mapping[str, str | float],
        Terminal("--factor", "CHANNEL=FACTOR"),
        "Factors of the channels: with a unit what one in the file is, such as displacement='0.005 mm' of an encoder's counts; "
        "a number alone multiplies the channel in its unit",
    ] = field(default_factory=dict)
    offsets: Annotated[
        Mapping[str, str | float],
        Terminal("--channel-offset", "CHANNEL=VALUE"),
        "What is added to the channels, after their factors, such as force='-12 N'",
    ] = field(default_factory=dict)
    header: Annotated[
        int | None,
        Quantity("", low=0),
        Terminal(metavar="LINE"),
        "Line of the names in a text, from 1; 0 where there is none",
    ] = None
    thousands: Annotated[
        str | None,
        Terminal(metavar="MARK"),
        "Mark between thousands in a text: a comma, a point, an apostrophe or a blank; the decimal mark is then the other one",
    ] = None

    encoding: Annotated[
        str | None,
        Terminal(metavar="NAME"),
        "Encoding of a text, such as cp1252 or shift_jis; where none is stated, it is UTF-8, UTF-16 with its mark, or Latin-1",
    ] = None
    delimiter: Annotated[
        str | None,
        Terminal(metavar="MARK"),
        "What parts the columns of a text: a comma, a semicolon, a bar, tab or blank; where none is stated, it is found",
    ] = None

    def check(self) -> None:
        """Refuse unknown channels, factors and offsets that are none, and marks and encodings that are none."""
        for argument in ("units", "columns", "factors", "offsets"):
            unknown = sorted(set(getattr(self, argument)) - set(self.CHANNELS))
            if unknown:
                raise InputError(
                    f"{argument} names {unknown[0]!r}, which is not a channel; choose from {', '.join(self.CHANNELS)}"
                )
        for channel in self.factors:
            self.factor(channel)
        for channel in self.offsets:
            self.offset(channel)
        if self.thousands is not None and self.thousands not in THOUSANDS:
            marks = " ".join(map(repr, THOUSANDS))
            raise InputError(f"thousands = {self.thousands!r} is not a mark between thousands; choose from {marks}")
        if self.delimiter is not None and self.delimiter not in DELIMITERS:
            marks = " ".join(map(repr, DELIMITERS))
            raise InputError(f"delimiter = {self.delimiter!r} does not part columns; choose from {marks}")
        if self.encoding is not None:
            try:
                "a".encode(self.encoding)
            except (LookupError, ValueError):
                raise InputError(
                    f"encoding = {self.encoding!r} is not known; choose one such as utf-8, cp1252, utf-16-le or shift_jis"
                ) from None

    @property
    def mark(self) -> str | None:
        """The character that parts columns, a blank for white space; None where it is to be found."""
        return None if self.delimiter is None else DELIMITERS[self.delimiter]

    def factor(self, channel: str) -> tuple[float, bool]:
        """The factor of a channel, 1 where none is stated, and whether it has a unit: it is then in SI."""
        stated = self.factors.get(channel, 1.0)
        try:
            factor, has_unit = float(stated), False
        except ValueError:
            factor, has_unit = _parsed(f"factors[{channel!r}]", stated, self.CHANNELS[channel]), True
        if not math.isfinite(factor) or factor == 0.0:
            raise InputError(f"factors[{channel!r}] = {factor:g} is not allowed; it must be finite and not 0")
        return factor, has_unit

    def offset(self, channel: str) -> float:
        """What is added to a channel, in SI."""
        return _parsed(f"offsets[{channel!r}]", self.offsets.get(channel, 0.0), self.CHANNELS[channel])

    @property
    def is_by_number(self) -> bool:
        """Whether every column is declared by its number, so that no name is needed."""
        columns = [column for column in self.columns.values() if column not in (None, "-")]
        return bool(columns) and all(isinstance(column, int) or column.isdigit() for column in columns)

    def refuse(self, path: str | Path, **reasons: str) -> None:
        """Raise :class:`FileError` where an option is set that a format cannot use: ``variable="a text has none"``."""
        for name, reason in reasons.items():
            if (stated := getattr(self, name)) not in (None, {}):
                raise FileError(path, f"{name} = {stated!r} was given, but {reason}; leave it out")


def _parsed(where: str, stated: str | float, si: str) -> float:
    try:
        value = parse(stated, si)
    except InputError as problem:
        raise InputError(f"{where}: {problem}") from None
    if not math.isfinite(value):
        raise InputError(f"{where} = {stated!r} is not finite; give a number, with its unit")
    return value


@dataclass(frozen=True)
class ColumnTable:
    """Columns as a file has them: names, units ("" unknown), both empty without a header, and ``(n, m)`` values.

    ``kinds`` says what each column holds: "number"; or s, of a "clock" since midnight, of a "stamp" and a "date" since the
    midnight before the first. Empty: all are numbers. ``stamps`` are the first row's texts of those that are not numbers, by
    column, ``groups`` what the file says of its session, its specimen and of there being no input, ``lines`` the line of each
    row in the file, ``empty`` the line of the first empty cell of each column that has one, ``short`` how many cells the last
    row lacks, ``above`` the lines above the numbers, ``delimiter`` what parts the cells,
    and ``notes`` what the history says of how it was read.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    kinds: tuple[str, ...] = ()
    stamps: Mapping[int, str] = field(default_factory=dict)
    groups: Mapping[str, str] = field(default_factory=dict)
    lines: Sequence[int] = ()
    empty: Mapping[int, int] = field(default_factory=dict)
    short: int = 0
    above: tuple[str, ...] = ()
    delimiter: str | None = None
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

    def place(self, row: int) -> str:
        """Where a row is: its line in the file, or its number."""
        return f"line {self.lines[row]}" if len(self.lines) else f"row {row}"


def columns_of(path: Path, table: ColumnTable, request: TextOptions) -> dict[str, int]:
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
    for channel in request.CHANNELS:
        if channel not in declared and (column := column_by_name(path, table, channel, set(used.values()))) is not None:
            used[channel] = column
    return {channel: used[channel] for channel in request.CHANNELS if channel in used}


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


def column_by_name(path: Path, table: ColumnTable, channel: str, taken: set[int]) -> int | None:
    """The column that has one of a channel's usual `NAMES`, or None; :class:`FileError` where several have one."""
    plain = [plain_name(name) for name in table.names]
    matching = [
        k
        for word in NAMES[channel]
        for k, name in enumerate(plain)
        if name == word and k not in taken and _may_be(word, table.unit(k))
    ]
    if len(matching) > 1:
        names = " and ".join(table.headers()[k] for k in matching)
        raise FileError(
            path,
            f"the columns {names} could all be the {channel}; declare which, --column {channel}=NAME or "
            f"columns={{{channel!r}: NAME}}, by the full header or the number from 0",
        )
    return matching[0] if matching else None


def _may_be(word: str, unit: str) -> bool:
    """Whether a usual name means its channel where the column states this unit: T in degrees is no time."""
    if word in ALSO_STRESS:
        return _measures(unit, "V")
    return word != "t" or not unit or not _measures(unit, "degC")


def plain_name(name: str) -> str:
    """A name in lower case and without accents: força is forca."""
    return "".join(c for c in unicodedata.normalize("NFKD", name.lower()) if not unicodedata.combining(c))


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


def name_and_unit(cell: str) -> tuple[str, str]:
    """The two parts of a cell of a header, ``force (N)`` or ``force [N]``; the unit is "" where there is none.

    Without brackets, ``Kraft/kN`` or ``Weg in mm`` where the name is one of `NAMES` and a unit follows.
    """
    match = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*", cell)
    if match is None and (bare := re.fullmatch(r"\s*(\S+?)(?:\s*/\s*|\s+in\s+)(\S+)\s*", cell)):
        is_name = any(plain_name(bare[1]) in words for words in NAMES.values())
        match = bare if is_name and bare[2].lower() in UNIT_WORDS else None
    return (match[1].strip(), match[2].strip()) if match else (cell.strip(), "")


def in_si(
    path: Path, table: ColumnTable, channel: str, column: int, request: TextOptions
) -> tuple[Array, tuple[str, ...]]:
    """A channel in the unit it is held in, with its factor and its offset, and what the history says of these."""
    si, stated, declared = request.CHANNELS[channel], table.unit(column), request.units.get(channel, "")
    (factor, has_unit), offset = request.factor(channel), request.offset(channel)
    values, notes = table.values[:, column], []
    if has_unit:
        for unit in filter(None, (stated, declared)):
            if _measures(unit, si):
                raise FileError(
                    path,
                    f"factors[{channel!r}] = {request.factors[channel]!r} has a unit, but the {channel} is in {unit!r}; give a "
                    "number alone, which multiplies it",
                )
    else:
        if stated and declared and _measures(stated, si):
            if to_si(1.0, stated, si) != to_si(1.0, declared, si):
                raise FileError(
                    path,
                    f"the header says {channel} is in {stated!r}, but units declares {declared!r}; leave it out of units",
                )
        elif stated and declared:
            notes.append(f"{channel} in {declared} as declared, {stated!r} in the file")
        try:
            values = to_si(values, declared or stated, si) if (declared or stated) != si else values
        except InputError as problem:
            one = f"--factor {channel}='0.005 {si}' or factors={{{channel!r}: '0.005 {si}'}}"
            raise FileError(path, f"{problem}; of counts or volts, say what one is, such as {one}") from None
    if channel in request.factors or channel in request.offsets:
        values = values * factor + offset
        what = f"{table.label(column)} in the file{f' [{stated}]' * bool(stated)}"
        added = f" plus {offset:g} {si}" * (channel in request.offsets)
        notes.append(f"{channel} is {request.factors.get(channel, 1)} times {what}{added}, as declared")
    return values, tuple(notes)


def _measures(unit: str, si: str) -> bool:
    """Whether a word is a unit of what ``si`` measures."""
    try:
        to_si(1.0, unit, si)
    except InputError:
        return False
    return True


def check_units(path: Path, table: ColumnTable, used: Mapping[str, int], request: TextOptions) -> None:
    """Raise :class:`FileError` with every column that has no unit, not the first one only."""
    bare = [
        channel
        for channel, column in used.items()
        if table.kind(column) == "number"
        and not (table.unit(column) or request.units.get(channel) or request.factor(channel)[1])
    ]
    if bare:
        names = ", ".join(table.label(used[channel]) for channel in bare)
        si = request.CHANNELS[bare[0]]
        raise FileError(
            path,
            f"the {'columns' if len(bare) > 1 else 'column'} {names} {'have' if len(bare) > 1 else 'has'} no unit; write it in "
            f"the header, such as {bare[0]} [{si}], or declare it: --unit {bare[0]}={si}, "
            f"units={{{bare[0]!r}: {si!r}}} or in reading.toml",
        )


def check_cells(path: Path, table: ColumnTable, used: Mapping[str, int], else_repair: str = "") -> None:
    """All but the time must be numbers, and no cell may be empty; ``else_repair`` is another way out of one that is."""
    for channel, column in used.items():
        if channel != "time" and table.kind(column) != "number":
            raise FileError(
                path,
                f"the column of the {channel} holds {table.stamps[column]!r}, which is not a number; declare another, "
                f"--column {channel}=NAME or columns={{{channel!r}: NAME}}",
            )
        if column in table.empty:
            instead = ", or give the sampling interval, --dt 0.01 or dt=0.01" if channel == "time" else else_repair
            raise FileError(
                path,
                f"line {table.empty[column]}: the cell of the {channel} is empty; repair or cut out the line{instead}",
            )


def check_stamps(path: Path, table: ColumnTable, time: Array) -> None:
    """Raise :class:`FileError` where samples have the same time stamp, in one line for all of them."""
    repeated = np.flatnonzero(np.diff(time) == 0)
    if len(repeated):
        k = int(repeated[0])
        mean = (time[-1] - time[0]) / (len(time) - 1)
        interval = f"{mean:.4g}" if mean > 0 else "0.01"
        where = f"lines {table.lines[k]} and {table.lines[k + 1]}" if len(table.lines) else f"rows {k} and {k + 1}"
        raise FileError(
            path,
            f"{where} have the same time stamp ({len(repeated)} such pair{'s' * (len(repeated) > 1)}); cut out one of two "
            f"equal lines, or, where the clock is coarser than the samples, give their interval, such as --dt {interval} or "
            f"dt={interval} (s), which goes before the stamps",
        )


def check_interval(path: Path, table: ColumnTable, column: int, time: Array, dt: float) -> str:
    """What the history says of time stamps that gave way to an interval [s]; :class:`FileError` where the two disagree."""
    known = time[np.isfinite(time)]
    steps = np.diff(known)
    span = float(known[-1] - known[0]) if len(known) else 0.0
    coarse = float(steps[steps > 0].min()) if np.any(steps > 0) else math.inf
    wanted = dt * (len(time) - 1)
    if abs(wanted - span) > 0.05 * max(span, 0.0) + coarse:
        mean = span / max(len(time) - 1, 1)
        raise FileError(
            path,
            f"dt = {dt:g} s was given, but the column {table.label(column)} is the time and steps by {mean:.4g} s on average; "
            "correct dt, or leave the column out, such as --column time=- or columns={'time': None}",
        )
    return f"time from the sampling interval, {dt:g} s, in the place of the stamps {table.label(column)}"
