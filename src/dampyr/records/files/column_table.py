"""From columns of numbers to a record: which column is which channel, and each channel in SI.

What records and ground motions have in common is in :mod:`dampyr.channel_columns`.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr import channel_columns, text_table
from dampyr.channel_columns import ColumnTable
from dampyr.errors import FileError
from dampyr.input_kinds import NO_INPUT
from dampyr.origin import ORIGIN_KINDS
from dampyr.phrases import counted
from dampyr.records.conditioning.integrated_displacement import with_integrated_displacement
from dampyr.records.conditioning.nominal_input import MEASURED, SOURCE
from dampyr.records.conditioning.repair_step import GAPS
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import CHANNELS, GROUPS, PUBLISHED, Array, Record

HALF_A_DAY = 43200.0  # s: a clock that goes back by more has passed midnight, one that goes back by less is wrong
GROUP = re.compile(
    rf"[#%]\s*(?:({'|'.join((*GROUPS, *PUBLISHED))})\s*:\s*(\S.*)|(origin)\s*:\s*({'|'.join(ORIGIN_KINDS)})"
    rf"|(input)\s*:\s*({NO_INPUT})\s*$)"
)
"""A comment above the numbers that states the session, the specimen, the origin, that there is no input, or the published data
set, as dampyr writes it."""


def read_text(path: Path, request: ReadOptions, kind: str, text: str | None = None) -> Record:
    """The record in a text file of columns, every channel in SI; ``text``, where it is given, is what the file holds."""
    if text is None:
        request.refuse(path, variable="a text has columns and no variables")
        table = text_table.read_table(path, request, by_number=request.is_by_number, comment=GROUP)
    else:
        table = text_table.table_of_text(path, text, request, request.is_by_number, comment=GROUP)
    matches = [match for line in table.above if (match := GROUP.fullmatch(line.strip()))]
    groups = {name: words.strip() for match in matches for name, words in [filter(None, match.groups())]}
    return record_of(path, replace(table, groups=groups), request, kind)


def record_of(path: Path, table: ColumnTable, request: ReadOptions, kind: str) -> Record:
    """The record in a table, every channel in SI; ``kind`` is the name of the format."""
    used = channel_columns.columns_of(path, table, request)
    _check_needed(path, table, used, request)
    measuring = {channel: column for channel, column in used.items() if channel != "time" or request.dt is None}
    columns = [column for channel, column in measuring.items() if channel != "time"]
    incomplete = np.isnan(table.values[:, columns]).any(axis=1) if request.fills_gaps else np.zeros(0, dtype=bool)
    whole = replace(
        table, empty={k: line for k, line in table.empty.items() if not (incomplete.any() and k in columns)}
    )
    channel_columns.check_cells(
        path, whole, measuring, f", or have it filled as a gap: --repair {GAPS} or repair='{GAPS}'"
    )
    channel_columns.check_units(path, table, measuring, request)
    channels: dict[str, Any] = {}
    said: list[str] = []
    for name, column in used.items():
        if name != "time":
            channels[name], notes = channel_columns.in_si(path, table, name, column, request)
            said += notes
    time, stamp, notes = _time(path, table, used.get("time"), request)
    gaps: tuple[str, ...] = ()
    if incomplete.any():
        gaps = (f"{counted(int(incomplete.sum()), 'row')} with an empty cell left out",)
        time, channels = time[~incomplete], {name: values[~incomplete] for name, values in channels.items()}
    measured = {name: channels.pop(name, None) for name in ("voltage", "current")}
    groups = dict(table.groups)
    inputs = request.input_channels(**measured, no_input=groups.pop("input", None) == NO_INPUT)
    if inputs["voltage"] is not None and inputs["current"] is not None:
        raise FileError(
            path,
            "voltage and current are both given; a record has one input, so leave one out, such as --column voltage=- or "
            "columns={'voltage': None}",
        )
    provenance = {"file": path.name, "format": kind, "header": ", ".join(table.headers())}
    provenance |= {name: groups.pop(name) for name in PUBLISHED if name in groups}
    is_measured = any(value is not None and value is inputs[name] for name, value in measured.items())
    fields: dict[str, Any] = dict(
        time=time,
        **channels,
        voltage=_constant(inputs["voltage"]),
        current=_constant(inputs["current"]),
        no_input=inputs["no_input"],
        name=path.stem,
        provenance=provenance | stamp | ({SOURCE: MEASURED} if is_measured else {}),
        history=(
            "read from columns, converted to SI",
            *table.notes,
            *said,
            *notes,
            *gaps,
            *request.replaced(**measured),
        ),
        **groups,
    )
    return Record(**fields) if "displacement" in channels else with_integrated_displacement(**fields)


def guess_channels(path: Path, table: ColumnTable) -> dict[str, int]:
    """Channel -> the column that has one of its usual names; those that are not certain are left out."""
    guessed: dict[str, int] = {}
    for channel in CHANNELS:
        with suppress(FileError):
            column = channel_columns.column_by_name(path, table, channel, set(guessed.values()))
            guessed |= {} if column is None else {channel: column}
    return guessed


def _check_needed(path: Path, table: ColumnTable, used: dict[str, int], request: ReadOptions) -> None:
    """Time (or ``dt``), force, and displacement or velocity have to be there."""
    instead = {"time": request.dt is not None, "displacement": "velocity" in used}
    absent = [name for name in ("time", "displacement", "force") if name not in used and not instead.get(name)]
    if absent:
        *others, last = (f"the {name}" for name in absent)
        missing = f"{', '.join(others)} or {last}" if others else last
        options = " ".join(f"--column {name}=NAME" for name in absent)
        call = ", ".join(f"{name!r}: NAME" for name in absent)
        also = ", or give the sampling interval: --dt 0.001, dt=0.001" if "time" in absent else ""
        raise FileError(
            path,
            f"no column is {missing} (there: {table.listed()}); declare which, {options} or columns={{{call}}}{also}",
        )


def _time(
    path: Path, table: ColumnTable, column: int | None, request: ReadOptions
) -> tuple[Array, dict[str, str], tuple[str, ...]]:
    """The time in s, the text of its first stamp for the provenance, and what the history says of it."""
    even = None if request.dt is None else request.dt * np.arange(len(table.values), dtype=float)
    if column is None:
        assert even is not None
        return even, {}, (f"time from the sampling interval, {request.dt:g} s",)
    stamp: dict[str, str] = {}
    notes: tuple[str, ...] = ("time stamps as s from the first one",)
    if table.kind(column) == "number":
        known = table.unit(column) or request.units.get("time") or request.factor("time")[1]
        if even is not None and not known:
            return even, {}, (f"time from the sampling interval, {request.dt:g} s, in the place of the stamps",)
        time, notes = channel_columns.in_si(path, table, "time", column, request)
    else:
        time, stamp, midnight = _stamps(path, table, column)
        notes = (notes[0] + midnight,)
    if even is not None:
        assert request.dt is not None
        return even, stamp, (channel_columns.check_interval(path, table, column, time, request.dt),)
    channel_columns.check_stamps(path, table, time)
    return time, stamp, notes


def _stamps(path: Path, table: ColumnTable, column: int) -> tuple[Array, dict[str, str], str]:
    """s from the first of the time stamps, what the provenance says of it, and that midnight was passed, or nothing."""
    seconds, first, midnight = table.values[:, column], table.stamps[column], ""
    if table.kind(column) == "clock":
        dates = [k for k in range(table.values.shape[1]) if table.kind(k) == "date"]
        if len(dates) == 1:
            seconds, first = seconds + table.values[:, dates[0]], f"{table.stamps[dates[0]]} {first}"
        else:
            midnights = np.cumsum(np.diff(seconds, prepend=seconds[0]) < -HALF_A_DAY)
            seconds = seconds + 86400.0 * midnights
            midnight = ", past midnight" * bool(midnights[-1])
    elif table.kind(column) == "date":
        raise FileError(path, f"the column of the time holds dates alone ({first}); declare the column of the clock")
    day = re.match(r"(\d{4})\D(\d{1,2})\D(\d{1,2})", first)
    date = {"date": "{}-{:0>2}-{:0>2}".format(*day.groups())} if day else {}
    return seconds - seconds[0], {"first_sample": first} | date, midnight


def _constant(values: Any) -> Any:
    """A channel that never changes is a constant input."""
    return float(values[0]) if np.ndim(values) == 1 and len(values) and np.ptp(values) == 0 else values
