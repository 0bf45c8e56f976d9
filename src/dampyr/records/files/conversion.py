"""Conversion: records written again in another format, each whole or not at all, no file overwritten."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from dampyr import registry
from dampyr.errors import InputError
from dampyr.records.conditioning.velocity import with_velocity
from dampyr.records.files.record_files import REGISTRY, writable_formats, write
from dampyr.records.record import Record, commonest_name


def convert(
    records: Iterable[Record], folder: str | Path, to: str = "h5", progress: Callable[[Path], None] | None = None
) -> list[Path]:
    """Write each record to ``folder/NAME.to``; the paths, in the order of the records.

    Parameters
    ----------
    records
        such as :func:`dampyr.records.read_campaign` gives; their names must differ.
    folder
        Where to; it is made. A file that is there already is never overwritten.
    to
        The suffix of the format, such as ``h5``, ``csv``, ``mat``, ``nc`` and ``parquet``. One that needs a velocity gets the
        derived one (:func:`dampyr.records.with_velocity`); the record's history says so.
    progress
        Called with each path once it is written.

    Raises
    ------
    InputError
        Before anything is written: a format that is not written, two records of one name, a file that is there.
    FileError
        A record that the format cannot hold, such as a smoothed one in columns; what was written before it stays.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> record = dp.records.Record(t, 0.01 * np.sin(6 * t), 50.0 * np.cos(6 * t), voltage=1.0, name="sine")
    >>> [path.name for path in dp.records.convert([record], "converted", to="csv")]
    ['sine.csv']
    """
    writable = writable_formats()
    kind = to.lower().removeprefix(".")
    if kind not in writable:
        raise InputError(f"records are not written as {to!r}; choose from {', '.join(writable)}")
    records = list(records)
    name, count = commonest_name(records)
    if count > 1:
        raise InputError(f"{count} records are called {name!r}; convert them into folders of their own")
    paths = [Path(folder) / f"{record.name}.{kind}" for record in records]
    existing = [path for path in paths if path.exists()]
    if existing:
        more = f" and {len(existing) - 1} more" if existing[1:] else ""
        raise InputError(f"{existing[0]}{more} is there already; choose another folder, or remove it")
    Path(folder).mkdir(parents=True, exist_ok=True)
    needs_velocity = getattr(registry.member(REGISTRY, kind), "NEEDS_VELOCITY", False)
    for record, path in zip(records, paths, strict=True):
        write(with_velocity(record) if needs_velocity and record.velocity is None else record, path)
        if progress is not None:
            progress(path)
    return paths
