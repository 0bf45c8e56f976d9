"""Parquet: columns of numbers and time stamps, with units in their names or in the metadata of the fields.

A name is as in a header of text, ``force [N]``; else the field's metadata ``units`` or ``unit`` is the unit. Session, specimen,
origin and published data set are metadata of the file. Other columns, such as texts, are left out. Read and written with
pyarrow, the extra ``parquet``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import whole_file
from dampyr.channel_columns import OF_TEXTS, Array, ColumnTable, name_and_unit
from dampyr.errors import FileError, InputError, install_line, one_line
from dampyr.records.files.column_table import record_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import CHANNELS, Record, as_stated, stated

TITLE, MEDIA_TYPE = "Parquet", "application/vnd.apache.parquet"
NANOSECONDS = 1e9  # in a second
DAY = 86400 * 10**9  # ns


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.parquet`` file, in SI."""
    reason = "a Parquet file names its columns"
    request.refuse(path, variable=reason, **dict.fromkeys(OF_TEXTS, reason))
    arrow = _arrow()
    try:
        stored = arrow.read_table(path)
        columns = [(field, stored.column(field.name)) for field in stored.schema if _kind(field.type)]
        values = [_values(column, _kind(field.type)) for field, column in columns]
    except InputError:
        raise
    except Exception as problem:  # pyarrow raises whatever the broken bytes lead it to
        raise FileError(
            path, f"is not a readable Parquet file ({one_line(problem)}); copy or export it again"
        ) from problem
    if not columns or not len(values[0]):
        raise FileError(path, "has no column of numbers with a row; export the test again")
    pairs = [name_and_unit(field.name) for field, _ in columns]
    kinds = tuple(_kind(field.type) for field, _ in columns)
    table = ColumnTable(
        names=tuple(name for name, _ in pairs),
        units=tuple(unit or _unit(field) for (_, unit), (field, _) in zip(pairs, columns)),
        values=np.column_stack(values),
        kinds=tuple("stamp" if kind == "stamp" else "number" for kind in kinds),
        stamps={k: str(columns[k][1][0].as_py()) for k, kind in enumerate(kinds) if kind == "stamp"},
        groups=as_stated(_texts(stored.schema.metadata)),
    )
    return record_of(path, table, request, TITLE)


def write(record: Record, path: Path) -> Path:
    """Write a record's channels in SI, a constant input as a column, so that :func:`read` gives them back exactly."""
    arrow = _arrow()
    from pyarrow import table

    channels = {name: getattr(record, name) for name in CHANNELS if getattr(record, name) is not None}
    columns = {f"{name} [{CHANNELS[name]}]": np.broadcast_to(v, record.n) for name, v in channels.items()}
    about = {"title": record.name, "role": record.role, **stated(record)}
    with whole_file(path) as temporary:
        arrow.write_table(table(columns).replace_schema_metadata(about), temporary)
    return path


def _arrow() -> Any:
    try:
        from pyarrow import parquet
    except ImportError as problem:
        raise InputError(f"Parquet files need pyarrow; install it: {install_line('parquet')}") from problem
    return parquet


def _kind(of_type: Any) -> str:
    """What a column holds: "number", "stamp", "duration", or nothing that a record can have."""
    from pyarrow import types

    if types.is_timestamp(of_type):
        return "stamp"
    if types.is_duration(of_type):
        return "duration"
    return "number" if types.is_integer(of_type) or types.is_floating(of_type) or types.is_decimal(of_type) else ""


def _values(column: Any, kind: str) -> Array:
    """The numbers of a column, NaN where there is none; s of a duration, and of stamps from the midnight before the first."""
    if kind == "number":
        return np.asarray(column.cast("float64").to_numpy(zero_copy_only=False), dtype=float)
    import pyarrow

    to = pyarrow.timestamp("ns", column.type.tz) if kind == "stamp" else pyarrow.duration("ns")
    whole = column.cast(to).cast("int64")
    if column.null_count:
        return np.asarray(whole.cast("float64").to_numpy(zero_copy_only=False), dtype=float) / NANOSECONDS
    ticks = whole.to_numpy(zero_copy_only=False)
    start = ticks[0] - ticks[0] % DAY if kind == "stamp" and len(ticks) else 0
    return np.asarray((ticks - start) / NANOSECONDS)


def _unit(field: Any) -> str:
    from pyarrow import types

    about = _texts(field.metadata)
    return about.get("units", "") or about.get("unit", "") or ("s" if types.is_duration(field.type) else "")


def _texts(metadata: Mapping[bytes, bytes] | None) -> dict[str, str]:
    return {name.decode(errors="replace"): text.decode(errors="replace") for name, text in (metadata or {}).items()}
