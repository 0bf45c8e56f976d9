"""Sources of records: the data folder, and the published data sets on this machine."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dampyr import records
from dampyr.console import safe_paths
from dampyr.console.record_formats import PLAIN_TEXT, SUFFIXES
from dampyr.errors import DampyrError, InputError, MissingData
from dampyr.records import Record
from dampyr.records.datasets import available_data_sets, data_set
from dampyr.records.files.campaign_folder import TABLE, campaign_rows, read_row
from dampyr.records.files.folder import natural
from dampyr.records.files.folder_metadata import reading_of
from dampyr.text_table import has_numbers

OWN = "data"
NOT_RECORDS = ("ensembles/", "motions/", "structures/")  # folders of the data folder that hold other files
MAX_RECORDS = 500  # each is read and described for the list of a page


@dataclass(frozen=True)
class RecordFolder:
    """A folder with records."""

    name: str
    title: str
    folder: Path


def sources(data: Path) -> list[RecordFolder]:
    """The data folder, and the data sets that are here."""
    available = [RecordFolder(OWN, "The data folder", data)]
    for name in available_data_sets():
        if not data_set(name).holds_records:
            continue
        try:
            available.append(RecordFolder(name, f"Published: {name}", records.locate(name).resolve()))
        except MissingData:
            continue
    return available


def source(data: Path, name: str) -> RecordFolder:
    """The source of this name, or MissingData."""
    by_name = {folder.name: folder for folder in sources(data)}
    if name not in by_name:
        raise MissingData(f"{name[:40]!r} is not a source of records here; choose from {', '.join(by_name)}")
    return by_name[name]


def keys(source: RecordFolder) -> list[str]:
    """The keys of the files of a source that may be records, such as ``data/lab/test 1.csv``; none is opened here."""
    names = sorted(safe_paths.files(source.folder, SUFFIXES), key=_order)
    return [
        f"{source.name}/{name}"
        for name in names
        if Path(name).name != TABLE and not (source.name == OWN and name.startswith(NOT_RECORDS))
    ]


def left_out(source: RecordFolder) -> dict[str, str]:
    """The keys of what is left out because of its name or as a link, with the reason."""
    return {f"{source.name}/{name}": why for name, why in safe_paths.left_out(source.folder, SUFFIXES).items()}


def superseded(described: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Why records are left out unless they are asked for, by their keys, as a command that reads their folder leaves them out.

    ``described`` is key -> what `dampyr.records.describe` gives.
    """
    best: dict[tuple[str, str], tuple[int, str]] = {}
    reasons, tries = {}, {}
    for key, about in described.items():
        provenance = about["provenance"]
        if provenance.get("complete") == "no":
            reasons[key] = "interrupted: its recording was not completed"
        elif "test" in provenance:
            place_of_test = (key.rpartition("/")[0], provenance["test"])
            tries[key] = place_of_test
            best[place_of_test] = max(best.get(place_of_test, (0, "")), (int(provenance.get("try", "1")), key))
    for key, place_of_test in tries.items():
        attempt, last = best[place_of_test]
        if key != last:
            reasons[key] = f"done again: try {attempt} of this test is the last"
    return reasons


def _order(name: str) -> tuple[Any, ...]:
    """Folder by folder, in the order in which a person lists files."""
    return (name.rpartition("/")[0], natural(Path(name)))


def is_record(path: Path) -> bool:
    """Whether a file is meant as a record: no text without numbers, and none that a ``reading.toml`` leaves out."""
    if path.suffix.lower() not in PLAIN_TEXT:
        return True
    try:
        metadata = reading_of(path.parent)
        return not metadata.is_ignored(path) and has_numbers(path, metadata.text_options(path))
    except (DampyrError, OSError, UnicodeDecodeError):
        return True


def place(data: Path, key: str) -> Path:
    """The file of a key."""
    name, _, rest = key.partition("/")
    return safe_paths.existing(source(data, name).folder, rest)


def read(data: Path, key: str) -> Record:
    """The record of a key, with what the campaign's table beside it says."""
    path = place(data, key)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if (path.parent / TABLE).is_file():
            row = next((row for row in campaign_rows(path.parent) if row.file == path), None)
            if row is not None:
                return read_row(row)
        return records.read(path)


def stamp(data: Path, key: str) -> tuple[Any, ...]:
    """Changes where the record of a key may read otherwise: its file, and what stands beside it."""
    path = place(data, key)
    status = path.stat()
    return (status.st_mtime_ns, status.st_size, _stamp(path.parent / TABLE), _stamp(path.parent / "reading.toml"))


def read_all(data: Path, chosen: list[str]) -> list[Record]:
    """The records of several keys, each once."""
    if not chosen:
        raise InputError("no record is chosen; choose one or more")
    keys_once = list(dict.fromkeys(chosen))
    chosen_records = [read(data, key) for key in keys_once]
    names = unique_names([record.name for record in chosen_records], keys_once)
    return [
        record
        if record.name == name
        else record.replace(note=f"called {name!r} here, as another has its name", name=name)
        for record, name in zip(chosen_records, names, strict=True)
    ]


def unique_names(names: list[str], keys_of_them: list[str]) -> list[str]:
    """The names of records, those that repeat with as much of their place in brackets as tells them apart."""
    repeated = {name for name, count in Counter(names).items() if count > 1}
    ways: list[Callable[[Path], str]] = [
        lambda path: path.parent.name,
        lambda path: path.name,
        lambda path: path.as_posix(),
    ]
    for way in ways:
        shown = [
            f"{name} ({way(Path(key))})" if name in repeated else name
            for name, key in zip(names, keys_of_them, strict=True)
        ]
        if len(set(shown)) == len(shown):
            return shown
    return shown


def _stamp(path: Path) -> int:
    return path.stat().st_mtime_ns if path.is_file() else 0
