"""National Instruments' TDMS, as LabVIEW writes it: each channel is a column, ``variable`` names the group of channels.

The unit is the channel's property ``unit_string``, as LabVIEW writes it. Without a channel of time, the interval of
the waveforms, ``wf_increment``, gives it. Waveforms that begin at different times (``wf_start_time``, ``wf_start_offset``),
as those of tasks that were started one after the other do, are brought to one time base: that of the channel that begins
last, over the time that all of them cover, by straight lines between samples. Read with npTDMS, the extra ``interop``.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.channel_columns import NAMES, OF_TEXTS, ColumnTable, name_and_unit
from dampyr.errors import FileError, InputError, install_line, one_line
from dampyr.records.files.column_table import record_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import GROUPS, Record

TITLE = "TDMS"
UNIT, INTERVAL, START, OFFSET = "unit_string", "wf_increment", "wf_start_time", "wf_start_offset"
SAME_START = 1e-3  # of an interval: what stamps are rounded by; a thousandth of a sample moves no number of a fit


def read(path: Path, request: ReadOptions) -> Record:
    """The record in one group of channels of a ``.tdms`` file."""
    request.refuse(path, **dict.fromkeys(OF_TEXTS, "a TDMS file names its channels"))
    try:
        from nptdms import TdmsFile
    except ImportError as problem:
        raise InputError(f"TDMS files need npTDMS; install it: {install_line('interop')}") from problem
    try:
        with path.open("rb") as stream, TdmsFile.open(stream) as file:
            group = _group(path, file, request.variable)
            channels = [channel for channel in group.channels() if len(channel)]
            declared = None if request.dt is None else float(request.dt)
            table, interval = _table(path, group.name, channels, {**file.properties, **group.properties}, declared)
    except InputError:
        raise
    except Exception as problem:  # npTDMS raises whatever the broken bytes lead it to
        raise FileError(
            path, f"is not a readable TDMS file ({one_line(problem)}); copy or export it again"
        ) from problem
    if "time" in request.columns:
        has_time = request.columns["time"] not in (None, "-")
    else:
        has_time = any(name.lower() in NAMES["time"] for name in table.names)
    if request.dt is None and interval is not None and not has_time:
        request = replace(request, dt=interval)
    return record_of(path, table, request, "TDMS")


def _group(path: Path, file: Any, wanted: str | None) -> Any:
    groups = {group.name: group for group in file.groups() if any(len(channel) for channel in group.channels())}
    available = ", ".join(map(repr, groups)) or "none"
    if wanted is not None:
        if wanted not in groups:
            raise FileError(path, f"there is no group {wanted!r} with samples; choose from {available}")
        return groups[wanted]
    if len(groups) != 1:
        raise FileError(
            path, f"has {len(groups)} groups with samples ({available}); name one, --variable NAME or variable=NAME"
        )
    return next(iter(groups.values()))


def _table(
    path: Path, group: str, channels: list[Any], properties: dict[str, Any], declared: float | None
) -> tuple[ColumnTable, float | None]:
    """The channels as columns, and the interval [s] of the waveforms where they have one; ``declared`` is that of a person."""
    increments = {channel.name: declared or float(channel.properties.get(INTERVAL, 0.0)) for channel in channels}
    intervals = {value for value in increments.values() if value > 0.0}
    if len(intervals) > 1:
        listed = ", ".join(f"{name} {value:g} s" for name, value in increments.items())
        raise FileError(
            path, f"the waveforms of {group!r} have several intervals ({listed}); give one, --dt 0.001 or dt=0.001"
        )
    interval = intervals.pop() if intervals else None
    starts = _starts(path, group, channels, increments)
    sizes = {channel.name: len(channel) for channel in channels}
    if not starts and len(set(sizes.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise FileError(
            path, f"the channels of {group!r} differ in length ({listed}); export them at one rate, or in groups"
        )
    columns, kinds, stamps = [], [], {}
    for k, channel in enumerate(channels):
        values = channel[:]
        if values.dtype.kind == "M":
            midnight = values[0].astype("datetime64[D]")
            columns.append((values - midnight) / np.timedelta64(1, "ns") * 1e-9)
            kinds.append("stamp")
            stamps[k] = str(values[0])
        elif values.dtype.kind in "fiub":
            columns.append(np.asarray(values, dtype=float))
            kinds.append("number")
        else:
            raise FileError(
                path, f"the channel {channel.name!r} holds {values.dtype} and no numbers; export it without"
            )
    notes = [f"the group {group!r}"]
    if starts and interval is not None:
        columns, note = _aligned(path, group, columns, starts, interval)
        notes.append(note)
    cells = [(name_and_unit(channel.name), str(channel.properties.get(UNIT, "")).strip()) for channel in channels]
    return ColumnTable(
        names=tuple(name for (name, _), _ in cells),
        units=tuple(stated or unit for (_, unit), stated in cells),
        values=np.column_stack(columns),
        kinds=tuple(kinds),
        stamps=stamps,
        groups={name: str(properties[name]).strip() for name in GROUPS if str(properties.get(name, "")).strip()},
        notes=tuple(notes),
    ), interval


def _starts(path: Path, group: str, channels: list[Any], increments: dict[str, float]) -> dict[str, float]:
    """When each waveform begins, s after the first of them; empty where all begin together, or none says when it does."""
    needed = START if any(START in channel.properties for channel in channels) else OFFSET
    stated = {channel.name: channel for channel in channels if needed in channel.properties}
    clocks = {
        name: (np.datetime64(channel.properties.get(START, 0), "us"), float(channel.properties.get(OFFSET, 0.0)))
        for name, channel in stated.items()
    }
    if not clocks:
        return {}
    first = min(clock for clock, _ in clocks.values())
    begins = {
        name: float((clock - first) / np.timedelta64(1, "s")) + offset for name, (clock, offset) in clocks.items()
    }
    earliest = min(begins.values())
    begins = {name: value - earliest for name, value in begins.items()}
    shortest = min((value for value in increments.values() if value > 0.0), default=0.0)
    if max(begins.values()) <= SAME_START * shortest:
        return {}
    unclear = [channel.name for channel in channels if channel.name not in begins or increments[channel.name] <= 0.0]
    if unclear:
        listed = ", ".join(f"{name} {value:.6g} s" for name, value in begins.items())
        raise FileError(
            path,
            f"the waveforms of {group!r} begin at different times ({listed} after the first), and {unclear[0]!r} does not say "
            f"when it was sampled ({START} and {INTERVAL}); export it with both, or without that channel",
        )
    return begins


def _aligned(
    path: Path, group: str, columns: list[Any], starts: dict[str, float], interval: float
) -> tuple[list[Any], str]:
    """The channels on the samples of the one that begins last, over the time that all cover, and what the history says."""
    begins = np.array(list(starts.values()))
    ends = begins + interval * np.array([len(column) - 1 for column in columns])
    last = int(np.argmax(begins))
    latest = begins[last] + interval * np.arange(len(columns[last]))
    base = latest[latest <= ends.min() + SAME_START * interval]
    listed = ", ".join(f"{name} {value:.6g} s" for name, value in starts.items())
    if base.size < 2:
        raise FileError(
            path,
            f"the waveforms of {group!r} begin at different times ({listed} after the first) and have no time in common; "
            "export channels that were sampled together",
        )
    aligned = [
        np.interp(base, begin + interval * np.arange(len(column)), column)
        for begin, column in zip(begins, columns, strict=True)
    ]
    note = (
        f"channels begin at different times ({listed} after the first): interpolated between samples at those of "
        f"{list(starts)[last]}, over the {base[-1] - base[0]:.4g} s that all cover"
    )
    return aligned, note
