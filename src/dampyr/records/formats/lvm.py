"""LabVIEW's measurement file: a header with separator and decimal mark, then packets of channels with units and steps.

Each packet has a header of its own (``Channels``, ``Samples``, ``Y_Unit_Label``, ``X0``, ``Delta_X``), a line of names with
``X_Value`` and ``Comment``, and its rows. ``X_Columns`` says where the time is: in no column (``No``: it is X0 + k Delta_X), in
the first (``One``) or in one before each channel (``Multi``). Packets of the same channels are one record after the other, and
are put together where the next begins a step after the last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dampyr.channel_columns import Array, ColumnTable, name_and_unit
from dampyr.errors import FileError
from dampyr.records.files.column_table import record_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record
from dampyr.text_table import decoded

TITLE = "LabVIEW"
SIGNATURE, END = "LabVIEW Measurement", "***End_of_Header***"
SPECIAL, SPECIAL_END = "***Start_Special***", "***End_Special***"
SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";", "space": " "}
TIME, COMMENT = "X_Value", "Comment"
SAME_STEP = 1e-3  # of a step: what the digits of X0 and Delta_X leave


@dataclass(frozen=True)
class Packet:
    """The channels of one packet: names, units, time (n,) s and values (n, m)."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    time: Array
    values: Array
    notes: tuple[str, ...] = ()


def read(path: Path, request: ReadOptions) -> Record:
    """The record in an ``.lvm`` file, with the time of its header in s; a column that holds the time is in s, too."""
    request.refuse(
        path,
        variable="an .lvm has no variables",
        header="an .lvm names its channels",
        dt="an .lvm has a time",
        delimiter="an .lvm states its separator",
    )
    text, note = decoded(path, request.encoding)
    packets = _packets(path, text.splitlines())
    if not packets:
        raise FileError(path, f"has no packet of samples after {END}; export the measurement again")
    first = packets[0]
    for k, packet in enumerate(packets[1:], start=2):
        if (packet.names, packet.units) != (first.names, first.units):
            raise FileError(
                path,
                f"packet {k} has the channels {', '.join(packet.names)} and packet 1 {', '.join(first.names)}; save each "
                "measurement in a file of its own",
            )
    time, notes = _joined(path, packets)
    notes = (*filter(None, (note,)), *notes)
    table = ColumnTable(
        names=("time", *first.names), units=("s", *first.units),
        values=np.column_stack([time, np.concatenate([packet.values for packet in packets])]), notes=notes,
    )  # fmt: skip
    return record_of(path, table, request, "LabVIEW measurement")


def _joined(path: Path, packets: Sequence[Packet]) -> tuple[Array, tuple[str, ...]]:
    """The time of all packets; each begins where the last ended, by its X0 or, where they all say the same X0, a step later."""
    times = [packets[0].time]
    for k, packet in enumerate(packets[1:], start=2):
        last = times[-1]
        step = float(last[-1] - last[0]) / max(len(last) - 1, 1)
        restarted = packet.time[0] == packets[0].time[0]
        begins = last[-1] + step if restarted else packet.time[0]
        if not begins > last[-1]:
            raise FileError(
                path,
                f"packet {k} begins at {packet.time[0]:g} s, before the last ends at {last[-1]:g} s; split the file",
            )
        if abs(begins - last[-1] - step) > SAME_STEP * step:
            raise FileError(
                path,
                f"packet {k} begins at {begins:g} s, not a step after {last[-1]:g} s, where the last ends: the measurement was "
                "interrupted; save its parts in files of their own",
            )
        times.append(packet.time - packet.time[0] + begins)
    notes = (f"{len(packets)} packets, one after the other",) if len(packets) > 1 else packets[0].notes
    return np.concatenate(times), notes


def _packets(path: Path, lines: Sequence[str]) -> list[Packet]:
    if not lines or not lines[0].startswith(SIGNATURE):
        raise FileError(path, f"does not begin with {SIGNATURE!r}; choose a measurement file of LabVIEW")
    end = next((k for k, line in enumerate(lines) if line.startswith(END)), None)
    if end is None:
        raise FileError(path, f"has no line {END}; export the measurement again")
    separator = _separator(path, lines[:end])
    general = {cells[0]: cells[1:] for cells in (line.split(separator) for line in lines[:end])}
    mark = (general.get("Decimal_Separator") or ["."])[0] or "."
    columns = (general.get("X_Columns") or ["No"])[0].strip().lower()
    packets, number = [], end + 1
    while (start := _next(lines, number)) < len(lines):
        finish = next((k for k in range(start, len(lines)) if lines[k].startswith(END)), None)
        if finish is None or finish + 1 >= len(lines):
            # without a header of its own: rows go on
            raise FileError(path, f"line {start + 1} begins a packet that has no {END}; export the measurement again")
        header = {cells[0]: cells[1:] for cells in (line.split(separator) for line in lines[start:finish])}
        rows = finish + 2
        number = next((k for k in range(rows, len(lines)) if not lines[k].strip()), len(lines))
        packets.append(_packet(path, header, lines, finish + 1, number, separator, mark, columns))
    return packets


def _separator(path: Path, header: Sequence[str]) -> str:
    for line in header:
        if line.startswith("Separator"):
            word = line[len("Separator") :].strip(" \t,;")
            if word.lower() in SEPARATORS:
                return SEPARATORS[word.lower()]
            raise FileError(path, f"its Separator is {word!r}; it must be Tab, Comma, Semicolon or Space")
    return "\t"


def _next(lines: Sequence[str], number: int) -> int:
    """The next line that is not empty, past blocks of special data."""
    while number < len(lines):
        if lines[number].startswith(SPECIAL):
            number = next((k for k in range(number, len(lines)) if lines[k].startswith(SPECIAL_END)), len(lines)) + 1
        elif not lines[number].strip():
            number += 1
        else:
            break
    return number


def _packet(
    path: Path, header: dict[str, list[str]], lines: Sequence[str], head: int, end: int, separator: str, mark: str,
    columns: str,
) -> Packet:  # fmt: skip
    """The packet whose names stand in the line ``head`` and whose rows end before the line ``end``."""

    def number(text: str) -> float:
        return float(text.strip().replace(mark, ".")) if text.strip() else np.nan

    names = [cell.strip() for cell in lines[head].split(separator)]
    names = names[: names.index(COMMENT)] if COMMENT in names else names
    try:
        rows = [[number(cell) for cell in line.split(separator)[: len(names)]] for line in lines[head + 1 : end]]
        x0, step = ([number(cell) for cell in header.get(key, []) if cell.strip()] for key in ("X0", "Delta_X"))
    except ValueError as problem:
        raise FileError(path, f"the packet from line {head + 1} on holds what is not a number ({problem})") from None
    if not rows:
        raise FileError(path, f"the packet from line {head + 1} on has no rows; export the measurement again")
    table = np.array([row + [np.nan] * (len(names) - len(row)) for row in rows])
    of_time = [k for k, name in enumerate(names) if name == TIME or (columns == "multi" and k % 2 == 0)]
    channels = [k for k in range(len(names)) if k not in of_time]
    counts = {int(number(cell)) for cell in header.get("Samples", []) if cell.strip()} or {len(table)}
    repeats = len(table) // max(counts)
    # packets under one heading (Multi_Headings No) are rows that go on
    if len(counts) > 1 or len(table) != repeats * max(counts) or (repeats > 1 and columns != "no"):
        raise FileError(
            path,
            f"the packet from line {head + 1} on has {len(table)} rows and says {', '.join(map(str, sorted(counts)))} samples; "
            "export channels of one rate, in whole packets",
        )
    notes = (f"{repeats} packets under one heading, taken as one after the other",) if repeats > 1 else ()
    if columns == "no":
        if len(set(step)) > 1 or len(set(x0)) > 1 or not step or step[0] <= 0:
            raise FileError(
                path,
                f"the channels of the packet from line {head + 1} on differ in X0 or Delta_X, or have none; export one rate",
            )
        time = (x0[0] if x0 else 0.0) + step[0] * np.arange(len(table))
    else:
        time = table[:, of_time[0]]
        differing = [names[k] for k in of_time if not np.array_equal(table[:, k], time)]
        if differing:
            raise FileError(
                path, f"its channels were sampled at times of their own ({TIME} columns differ); export one rate"
            )
    units = [cell.strip() for cell in header.get("Y_Unit_Label", [])]
    filled = [unit for unit in units if unit]
    pairs = [name_and_unit(names[k]) for k in channels]
    # with a column of time before each channel the units may stand below these
    stated = filled if len(filled) == len(channels) else [*units, *[""] * len(channels)][: len(channels)]
    return Packet(
        tuple(name for name, _ in pairs),
        tuple(unit or bracketed for unit, (_, bracketed) in zip(stated, pairs, strict=True)),
        np.asarray(time, dtype=np.float64),
        table[:, channels],
        notes,
    )
