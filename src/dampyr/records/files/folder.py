"""Folder of tests without a table: every file that is a record, named by its stem, in natural order."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

from dampyr import registry
from dampyr.errors import DampyrWarning, FileError, InputError, MissingData
from dampyr.records.files.folder_metadata import DECIMAL, NAME, reading_of
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.record_files import REGISTRY, read_file, warn_of_integrated
from dampyr.records.formats import h5
from dampyr.records.record import Record, commonest_name
from dampyr.text_table import has_numbers

DAMPYR = ".h5"  # the suffix of dampyr's own files


def read_folder(folder: Path, options: ReadOptions, incomplete: bool = False) -> list[Record]:
    """The records in the files of a folder, in natural order.

    Every file with a suffix that is read is a record, but hidden files, those that ``reading.toml`` ignores, and texts without
    a line of numbers, such as a README; these are named in a warning. Of dampyr's own files the latest complete try of each
    test is taken, or with ``incomplete`` every one but those that ended before they had 8 samples, with a warning.
    """
    files = record_files(folder, options)
    selected = files if incomplete else _latest(files)
    records, few = [], []
    for path in selected:
        try:
            records += [_read(path, part) for part in _parts(path, options)]
        except h5.FewSamples as problem:
            few.append(f"{path.name} ({problem.samples})")
    if few:
        names = ", ".join(few)
        warnings.warn(f"{folder}: left out, too few samples for a record: {names}", DampyrWarning, stacklevel=3)
    if not incomplete:
        _check_names(folder, records)
    warn_of_integrated(records)
    return records


def record_files(folder: Path, options: ReadOptions | None = None) -> list[Path]:
    """The files of a folder that are records, in natural order; ``options`` are those of a caller.

    Raises
    ------
    MissingData
        There are none.
    FileError
        A pattern of ``reading.toml`` is of no file.
    """
    metadata = reading_of(folder)
    suffixes = {f".{name}" for name in registry.names(REGISTRY)}
    visible = [path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")]
    candidates = sorted((path for path in visible if path.suffix.lower() in suffixes), key=natural)
    metadata.check_patterns(candidates)
    remaining = [path for path in candidates if not metadata.is_ignored(path)]
    prose = [
        path for path in remaining if _is_text(path) and not has_numbers(path, metadata.text_options(path, options))
    ]
    if prose:
        names = ", ".join(path.name for path in prose)
        warnings.warn(f"{folder}: left out, no line of numbers: {names}", DampyrWarning, stacklevel=4)
    records = [path for path in remaining if path not in prose]
    if not records:
        raise MissingData(
            f"{folder}: the folder has no records; give a folder with {', '.join(sorted(suffixes))} files"
        )
    return records


def _is_text(path: Path) -> bool:
    """Whether the format of the file's suffix is plain text, which a README may have too."""
    module = registry.member(REGISTRY, path.suffix.lower().removeprefix("."))
    return bool(getattr(module, "PLAIN_TEXT", False))


def natural(path: Path) -> tuple[Any, ...]:
    """The order in which a person lists files: test2 before test10, 0.25A before 0.5A, 0p25A and 0,25A before 0p5A."""
    parts = re.split(r"(\d+(?:[.,px]\d+)?)", path.name.lower())
    numbers = (DECIMAL.sub(".", part) if k % 2 else part for k, part in enumerate(parts))
    return (*((float(part), "") if k % 2 else (-1.0, part) for k, part in enumerate(numbers)), (-1.0, path.name))


def _latest(files: list[Path]) -> list[Path]:
    """Without the tries of a test that were not completed or were done again.

    Of files that call themselves the same try of the same test none is the later one: both stay, and their name is an error.
    """
    latest: dict[str, tuple[int, list[Path]]] = {}
    for path in (path for path in files if path.suffix.lower() == DAMPYR):
        state = h5.state(path)
        attempt, same = latest.get(state.test, (state.attempt, []))
        if state.complete and state.attempt >= attempt:
            latest[state.test] = (state.attempt, [*same, path] if state.attempt == attempt else [path])
    taken = {path for _, paths in latest.values() for path in paths}
    return [path for path in files if path.suffix.lower() != DAMPYR or path in taken]


def _read(path: Path, options: ReadOptions) -> Record:
    try:
        return read_file(path, options)
    except FileError as problem:
        if not _is_text(path) or problem.path != path or NAME in str(problem):
            raise
        raise FileError(
            path,
            f"{str(problem).removeprefix(f'{path}: ')} (for all files at once: {NAME}; not a record? ignore it in {NAME})",
        ) from problem


def _parts(path: Path, options: ReadOptions) -> list[ReadOptions]:
    """The options of each record in a file: those of the folder, or one ``variable`` after the other of a file with several."""
    module = registry.member(REGISTRY, path.suffix.lower().removeprefix("."))
    variables = module.parts(path) if hasattr(module, "parts") and options.variable is None else []
    return [replace(options, variable=variable) for variable in variables] or [options]


def _check_names(folder: Path, records: list[Record]) -> None:
    name, count = commonest_name(records)
    if count > 1:
        files = ", ".join(r.provenance.get("file", f"{r.name}{DAMPYR}") for r in records if r.name == name)
        where = " (a .h5 file has its record's name inside)" if DAMPYR in files else ""
        raise InputError(
            f"{folder}: {count} records are called {name!r} (from {files}); ignore or rename all but one{where}"
        )
