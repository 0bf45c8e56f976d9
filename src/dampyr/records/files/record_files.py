"""Reading and writing records: the suffix of the path picks the format."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from dampyr import registry
from dampyr.errors import DampyrWarning, FileError, InputError, MissingData, one_line
from dampyr.options import takes
from dampyr.phrases import listing
from dampyr.records.conditioning.force_lag import correct_delay
from dampyr.records.conditioning.integrated_displacement import INTEGRATED, is_integrated
from dampyr.records.conditioning.lowpass import with_lowpass
from dampyr.records.conditioning.repair import as_stated
from dampyr.records.conditioning.smoothing import with_smoothing
from dampyr.records.datasets import data_set_of_file
from dampyr.records.files.folder_metadata import INPUTS, TABLES, FolderReading, reading_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import GROUPS, Record
from dampyr.source_file import check_name, source_file

REGISTRY = "dampyr.records.formats"
SAVED_AS = {".xls": "an Excel workbook of before 2007, which is not read; open it and save it as .xlsx or as .csv"}
"""Suffixes that people bring, and what they do with such a file."""


@takes(ReadOptions)
def read(path: str | Path, options: ReadOptions | None = None, **keywords: Any) -> Record:
    """Read one test from a file; the suffix says which format it is.

    What no argument states is taken from the ``reading.toml`` beside the file, where there is one
    (:mod:`dampyr.records.files.folder_metadata`).

    Parameters
    ----------
    path
        such as ``.mat`` (MATLAB), ``.csv``, ``.txt`` and ``.dat`` (columns), ``.xlsx``, ``.tdms``,
        ``.h5`` (dampyr's own); each file of ``dampyr.records.formats`` is one format.
    options
        the further arguments as one object; those that are given by name take their places. A session and a specimen go before
        what a file says itself, and the history says so. ``cut`` is refused, as it makes several records of one:
        `dampyr.records.cut` takes the record that is read, and `read_campaign` cuts those of a folder.

    A file with a velocity and no displacement is integrated
    (:func:`dampyr.records.conditioning.velocity.with_integrated_displacement`), with a warning.

    Raises
    ------
    MissingData
        There is no such file.
    FileError
        The file is wrong: one line with the file, the value and the repair.
    InputError
        An argument is wrong.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> written = dp.records.Record(t, 0.01 * np.sin(6 * t), 50.0 * np.cos(6 * t))
    >>> record = dp.records.read(dp.records.write(written, "test.csv"), voltage=1.98)
    >>> record.n, record.input, record.input_value
    (101, 'V', 1.98)
    """
    options = ReadOptions.of("read", options, keywords)
    if options.cut is not None:
        raise InputError(
            f"cut = {options.cut!r} makes several records of one file; read it without, and give the record to "
            "dampyr.records.cut, or its folder to read_campaign"
        )
    record = read_file(Path(path), options)
    warn_of_integrated([record])
    return record


def read_file(path: Path, options: ReadOptions) -> Record:
    """As :func:`read`, without its warning."""
    available = registry.names(REGISTRY)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in available:
        if not path.exists():
            raise MissingData(f"{path}: there is no such file or folder; check the path")
        if path.suffix.lower() in SAVED_AS:
            raise FileError(path, f"is {SAVED_AS[path.suffix.lower()]}")
        raise FileError(path, f"the suffix {path.suffix!r} is not known; choose from {_suffixes(available)}")
    if not path.is_file():
        raise MissingData(f"{path}: there is no such file; check the path")
    check_name(path)
    try:
        metadata = reading_of(path.parent)
        request = _merged(metadata, path, options)
        record = _with_request(registry.member(REGISTRY, kind).read(path, request), request, metadata, path)
        source = source_file(path)
        dataset = data_set_of_file(source, path.parent)
        published = {}
        if dataset is not None:
            published = {"data_set": dataset.name, "doi": dataset.doi, "licence": dataset.licence_in_words}
            published |= {"data_set_version": dataset.version} if dataset.version else {}
        return replace(record, source_file=source, provenance=dict(record.provenance) | published)
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, str(problem)) from problem
    except OSError as problem:
        raise FileError(path, f"cannot be read ({one_line(problem)}); check the file and its permissions") from problem


def warn_of_integrated(records: Iterable[Record]) -> None:
    """Warn, in one line, of records whose displacement was integrated from the velocity."""
    names = [record.name for record in records if is_integrated(record)]
    if names:
        warnings.warn(
            f"{listing(names, 3)}: displacement {INTEGRATED}; what became of its drift is in the notes and the history",
            DampyrWarning,
            stacklevel=3,
        )


def _merged(metadata: FolderReading, path: Path, options: ReadOptions) -> ReadOptions:
    """The caller's options, and where it sets none those of ``reading.toml``."""
    stated = {name: value for name, value in options.as_keywords().items() if value is not None and value is not False}
    of_folder = metadata.options_of(path, has_input=any(name in stated for name in INPUTS))
    tables = {name: {**of_folder.get(name, {}), **stated[name]} for name in TABLES}
    return ReadOptions(**{**of_folder, **stated, **tables}, thresholds=options.thresholds)


def _with_request(record: Record, request: ReadOptions, metadata: FolderReading, path: Path) -> Record:
    """The record with all that is stated of it: its repairs, its force, moving average, low-pass, session, specimen, role."""
    if request.thresholds is not None:
        record = replace(record, thresholds=request.thresholds)
    if request.repair is not None:
        record = as_stated(record, request.repair)
    if request.force_sign == -1:
        record = record.replace(note="force turned, as its sign was declared", force=-record.force)
    if request.force_delay:
        record = correct_delay(record, request.force_delay)
    if request.smoothed is not None:
        record = with_smoothing(record, request.smoothed)
    if request.lowpass is not None:
        record = with_lowpass(record, request.lowpass)
    for name in GROUPS:
        stated, stored = getattr(request, name), getattr(record, name)
        if stated is not None and stated != stored:
            instead = "" if stored is None else f", {stored!r} in the file"
            record = record.replace(note=f"{name} {stated!r} as stated{instead}", **{name: stated})
    if metadata.is_validation(path) and record.role != "validation":
        record = record.replace(note=f"role validation from {metadata.path.name}", role="validation")
    return record


def write(record: Record, path: str | Path, **details: Any) -> Path:
    """Write ``record`` to ``path`` (.h5, .csv, .mat, ...) whole or not at all, and return the path.

    ``details`` go to the format, such as ``raw`` for :func:`dampyr.records.formats.h5.write`. A record that is smoothed and not
    undone is refused by every format that cannot say so, all but .h5: :class:`~dampyr.errors.FileError`.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> record = dp.records.Record(t, 0.01 * np.sin(6 * t), 50.0 * np.cos(6 * t), voltage=1.0)
    >>> path = dp.records.write(record, "test.h5")
    >>> bool(np.all(dp.records.read(path).force == record.force))
    True
    """
    path = Path(path)
    writable = writable_formats()
    kind = path.suffix.lower().removeprefix(".")
    if kind not in writable:
        raise FileError(path, f"records are not written as {path.suffix!r}; choose from {_suffixes(writable)}")
    module = registry.member(REGISTRY, kind)
    if record.smoothed is not None and not getattr(module, "KEEPS_SMOOTHING", False):
        raise FileError(
            path, f"{module.TITLE} files cannot say that the record is smoothed; write .h5, or undo it first"
        )
    module.write(record, path, **details)
    return path


def writable_formats() -> list[str]:
    """The suffixes, without their dots, of the formats that are written."""
    return [name for name, module in registry.members(REGISTRY) if hasattr(module, "write")]


def _suffixes(names: list[str]) -> str:
    return ", ".join(f".{name}" for name in names)
