"""Sources of records: the data folder, and the published data sets on this machine."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from dampyr import records
from dampyr.console import safe_paths
from dampyr.console.record_formats import PLAIN_TEXT, SUFFIXES
from dampyr.errors import DampyrError, InputError, MissingData
from dampyr.records import Record
from dampyr.records.campaign_folder import TABLE, campaign_rows
from dampyr.records.datasets import DATA_SETS
from dampyr.records.folder import natural
from dampyr.records.folder_metadata import reading_of
from dampyr.records.text_columns import has_numbers

OWN = "data"
NOT_RECORDS = ("ensembles/",)
MAX_RECORDS = 500  # each is read and described for the list of a page


@dataclass(frozen=True)
class Source:
    """A folder with records."""

    name: str
    title: str
    folder: Path


def sources(data: Path) -> list[Source]:
    """The data folder, and the data sets that are here."""
    available = [Source(OWN, "The data folder", data)]
    for dataset in DATA_SETS:
        try:
            available.append(Source(dataset.name, f"Published: {dataset.name}", records.locate(dataset.name).resolve()))
        except MissingData:
            continue
    return available


def source(data: Path, name: str) -> Source:
    """The source of this name, or MissingData."""
    for one in sources(data):
        if one.name == name:
            return one
    raise MissingData(
        f"{name[:40]!r} is not a source of records here; choose from {', '.join(s.name for s in sources(data))}"
    )


def keys(of: Source) -> list[str]:
    """The keys of the records of a source, such as ``data/lab/test 1.csv``; files that are no records are left out."""
    record_keys = []
    for name in sorted(safe_paths.files(of.folder, SUFFIXES), key=_order):
        path = of.folder / name
        if path.name == TABLE or name.startswith(NOT_RECORDS) or not _is_record(path):
            continue
        record_keys.append(f"{of.name}/{name}")
    return record_keys[:MAX_RECORDS]


def _order(name: str) -> tuple[Any, ...]:
    """Folder by folder, in the order in which a person lists files."""
    return (name.rpartition("/")[0], natural(Path(name)))


def _is_record(path: Path) -> bool:
    if path.suffix.lower() not in PLAIN_TEXT:
        return True
    try:
        return has_numbers(path) and not reading_of(path.parent).is_ignored(path)
    except (DampyrError, OSError, UnicodeDecodeError):
        return True


def place(data: Path, key: str) -> Path:
    """The file of a key."""
    name, _, rest = key.partition("/")
    return safe_paths.existing(source(data, name).folder, rest)


def read(data: Path, key: str) -> Record:
    """The record of a key, with what the campaign's table beside it says."""
    path = place(data, key)
    stamp = path.stat()
    return _read(
        path, stamp.st_mtime_ns, stamp.st_size, _stamp(path.parent / TABLE), _stamp(path.parent / "reading.toml")
    )


def described(data: Path, key: str) -> dict[str, Any]:
    """What is known of the record of a key; ``problem`` instead where it cannot be read."""
    return _described(read(data, key))


def read_all(data: Path, chosen: list[str]) -> list[Record]:
    """The records of several keys, each once."""
    if not chosen:
        raise InputError("no record is chosen; choose one or more")
    return [read(data, key) for key in dict.fromkeys(chosen)]


def _stamp(path: Path) -> int:
    return path.stat().st_mtime_ns if path.is_file() else 0


@lru_cache(maxsize=256)
def _read(path: Path, *_: int) -> Record:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if (path.parent / TABLE).is_file():
            row = next((row for row in campaign_rows(path.parent) if row.file == path), None)
            if row is not None:
                return records.read_row(row)
        return records.read(path)


@lru_cache(maxsize=512)
def _described(record: Record) -> dict[str, Any]:
    return records.describe(record)
