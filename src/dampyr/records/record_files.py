"""Reading and writing records: the suffix of the path picks the format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from dampyr import registry
from dampyr.errors import FileError, InputError, MissingData
from dampyr.records.folder_metadata import FolderReading, reading_of
from dampyr.records.nominal_input import agrees
from dampyr.records.record import CHANNELS, Array, Record

REGISTRY = "dampyr.records.formats"


@dataclass(frozen=True)
class Request:
    """What the caller says about a file: the input, the units and the columns that it does not say itself."""

    voltage: float | Array | None = None
    current: float | Array | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str | int | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for argument in ("units", "columns"):
            unknown = sorted(set(getattr(self, argument)) - set(CHANNELS))
            if unknown:
                raise InputError(
                    f"{argument} names {unknown[0]!r}, which is no channel; choose from {', '.join(CHANNELS)}"
                )

    def input_channels(self, voltage: Any = None, current: Any = None) -> dict[str, Any]:
        """The input from the call and from the file together.

        What the file states must be what was said; what it measured must agree with it, and gives way to it.
        """
        channels: dict[str, Any] = {}
        for name, said, stored in (("voltage", self.voltage, voltage), ("current", self.current, current)):
            if said is not None and stored is not None and not _same(said, stored):
                raise InputError(_contradiction(name, said, stored))
            channels[name] = said if said is not None else stored
        return channels

    def replaced(self, voltage: Any = None, current: Any = None) -> tuple[str, ...]:
        """What the history says of a measured input that gave way to what was said."""
        pairs = (("voltage", self.voltage, voltage), ("current", self.current, current))
        return tuple(
            f"{name} {np.mean(said):g} {CHANNELS[name]} as stated; {np.mean(stored):.4g} {CHANNELS[name]} as measured"
            for name, said, stored in pairs
            if said is not None and stored is not None and not np.array_equal(said, stored)
        )


def _same(said: Any, stored: Any) -> bool:
    if np.array_equal(said, stored):
        return True
    return np.ndim(said) == 0 and np.ndim(stored) == 1 and agrees(float(said), stored)


def _contradiction(name: str, said: Any, stored: Any) -> str:
    unit = CHANNELS[name]
    if np.ndim(stored) == 0:
        return (
            f"{name} = {np.mean(said):g} {unit} was given, but the file says "
            f"{np.mean(stored):g} {unit}; leave {name} out of the call"
        )
    return (
        f"{name} = {np.mean(said):g} {unit} was given, but the file's column has {np.min(stored):.4g} to "
        f"{np.max(stored):.4g} {unit} (mean {np.mean(stored):.4g}), which is further from it than 5 % or 0.05 {unit}; "
        f"leave {name} out of the call"
    )


def read(
    path: str | Path,
    voltage: float | Array | None = None,
    current: float | Array | None = None,
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, str | int | None] | None = None,
) -> Record:
    """Read one test from a file; the suffix says which format it is.

    What is not said here is taken from the ``reading.toml`` beside the file, where there is one
    (:mod:`dampyr.records.folder_metadata`): units, columns, input and role.

    Parameters
    ----------
    path
        such as ``.mat`` (the campaign's MATLAB files), ``.csv`` and ``.txt`` (columns), ``.h5`` (dampyr's own); each file of
        ``dampyr.records.formats`` is one format.
    voltage, current
        The damper's input at the coil, V or A, where the file does not hold it. A measured column of the file
        gives way to it where it agrees (to 5 %, or 0.05 V or A if that is more); else it is an error.
    units
        Unit of each channel that the file does not state, such as ``{"displacement": "mm"}``.
    columns
        Name (or number, from 0) of the column of each channel, where the header's own words do not tell; None, or
        "-", for a channel that is not to be read.

    Raises
    ------
    MissingData
        There is no such file.
    FileError
        The file is wrong: one line with the file, the value and the repair.
    """
    path = Path(path)
    available = registry.names(REGISTRY)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in available:
        raise FileError(path, f"the suffix {path.suffix!r} is not known; choose from {_suffixes(available)}")
    if not path.is_file():
        raise MissingData(f"{path}: there is no such file; check the path")
    try:
        metadata = reading_of(path.parent)
        request = _request(metadata, path, voltage, current, Request(units=units or {}, columns=columns or {}))
        return _as_the_folder_says(registry.member(REGISTRY, kind).read(path, request), metadata, path)
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, str(problem)) from problem
    except OSError as problem:
        raise FileError(path, f"cannot be read ({_one_line(problem)}); check the file and its permissions") from problem


def _request(metadata: FolderReading, path: Path, voltage: Any, current: Any, said: Request) -> Request:
    """What the caller says, and where it says nothing what ``reading.toml`` does."""
    given = {"voltage": voltage, "current": current}
    inputs = given if voltage is not None or current is not None else given | metadata.input_of(path)
    units, columns = {**metadata.units, **said.units}, {**metadata.columns, **said.columns}
    return Request(**inputs, units=units, columns=columns)


def _as_the_folder_says(record: Record, metadata: FolderReading, path: Path) -> Record:
    """The role that ``reading.toml`` gives the record, noted in its history."""
    if not metadata.is_validation(path) or record.role == "validation":
        return record
    return record.replace(note=f"role validation from {metadata.path.name}", role="validation")


def write(record: Record, path: str | Path, **details: Any) -> Path:
    """Write ``record`` to ``path`` (.h5, .csv, .mat, ...) whole or not at all, and return the path.

    ``details`` go to the format, such as ``raw`` for :func:`dampyr.records.formats.h5.write`.
    """
    path = Path(path)
    writable = [name for name, module in registry.members(REGISTRY) if hasattr(module, "write")]
    kind = path.suffix.lower().removeprefix(".")
    if kind not in writable:
        raise FileError(path, f"records are not written as {path.suffix!r}; choose from {_suffixes(writable)}")
    registry.member(REGISTRY, kind).write(record, path, **details)
    return path


def _suffixes(names: list[str]) -> str:
    return ", ".join(f".{name}" for name in names)


def _one_line(problem: BaseException) -> str:
    return " ".join(str(problem).split()) or type(problem).__name__
