"""National Instruments' TDMS, as LabVIEW writes it: each channel is a column, ``variable`` names the group of channels.

The unit is the channel's property ``unit_string``, as LabVIEW writes it. Without a channel of time, the interval of
the waveforms, ``wf_increment``, gives it. Read with npTDMS, the extra ``interop``.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.errors import FileError, InputError, install_line
from dampyr.records.column_table import WORDS, Table, name_and_unit, record_of
from dampyr.records.record import GROUPS, Record
from dampyr.records.record_files import Request

TITLE = "TDMS"
UNIT, INTERVAL = "unit_string", "wf_increment"


def read(path: Path, request: Request) -> Record:
    """The record in one group of channels of a ``.tdms`` file."""
    request.refuse(path, header="a TDMS file names its channels")
    try:
        from nptdms import TdmsFile
    except ImportError as problem:
        raise InputError(f"TDMS files need npTDMS; install it: {install_line('interop')}") from problem
    try:
        with path.open("rb") as stream, TdmsFile.open(stream) as file:
            group = _group(path, file, request.variable)
            channels = [channel for channel in group.channels() if len(channel)]
            table, interval = _table(path, group.name, channels, {**file.properties, **group.properties})
    except InputError:
        raise
    except Exception as problem:  # npTDMS raises whatever the broken bytes lead it to
        reason = " ".join(str(problem).split()) or type(problem).__name__
        raise FileError(path, f"is no readable TDMS file ({reason}); copy or export it again") from problem
    if request.dt is None and interval is not None and not _has_time(table, request):
        request = replace(request, dt=interval)
    return record_of(path, table, request, "TDMS")


def _group(path: Path, file: Any, wanted: str | None) -> Any:
    groups = {group.name: group for group in file.groups() if any(len(channel) for channel in group.channels())}
    there = ", ".join(map(repr, groups)) or "none"
    if wanted is not None:
        if wanted not in groups:
            raise FileError(path, f"there is no group {wanted!r} with samples; choose from {there}")
        return groups[wanted]
    if len(groups) != 1:
        raise FileError(
            path, f"has {len(groups)} groups with samples ({there}); name one, --variable NAME or variable=NAME"
        )
    return next(iter(groups.values()))


def _table(path: Path, group: str, channels: list[Any], properties: dict[str, Any]) -> tuple[Table, float | None]:
    """The channels as columns, and the interval of the waveforms where they have one."""
    sizes = {channel.name: len(channel) for channel in channels}
    if len(set(sizes.values())) > 1:
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
    increments = {channel.name: float(channel.properties.get(INTERVAL, 0.0)) for channel in channels}
    intervals = {value for value in increments.values() if value > 0.0}
    if len(intervals) > 1:
        listed = ", ".join(f"{name} {value:g} s" for name, value in increments.items())
        raise FileError(
            path, f"the waveforms of {group!r} have several intervals ({listed}); give one, --dt 0.001 or dt=0.001"
        )
    cells = [(name_and_unit(channel.name), str(channel.properties.get(UNIT, "")).strip()) for channel in channels]
    return Table(
        names=tuple(name for (name, _), _ in cells),
        units=tuple(stated or unit for (_, unit), stated in cells),
        values=np.column_stack(columns),
        kinds=tuple(kinds),
        stamps=stamps,
        groups={name: str(properties[name]).strip() for name in GROUPS if str(properties.get(name, "")).strip()},
        notes=(f"the group {group!r}",),
    ), (intervals.pop() if intervals else None)


def _has_time(table: Table, request: Request) -> bool:
    if "time" in request.columns:
        return request.columns["time"] not in (None, "-")
    return any(name.lower() in WORDS["time"] for name in table.names)
