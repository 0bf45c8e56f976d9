"""Reading and writing records: the suffix of the path picks the format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from dampyr import catalogue
from dampyr.errors import FileError, InputError, MissingData
from dampyr.records.record import CHANNELS, Array, Record

SHELF = "dampyr.records.formats"


@dataclass(frozen=True)
class Request:
    """What the caller says about a file: the input, the units and the columns that it does not say itself."""

    voltage: float | Array | None = None
    current: float | Array | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str | int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for argument in ("units", "columns"):
            unknown = sorted(set(getattr(self, argument)) - set(CHANNELS))
            if unknown:
                raise InputError(
                    f"{argument} names {unknown[0]!r}, which is no channel; choose from {', '.join(CHANNELS)}"
                )

    def input_channels(self, voltage: Any = None, current: Any = None) -> dict[str, Any]:
        """The input from the call and from the file together; both at once must agree."""
        found: dict[str, Any] = {}
        for name, said, stored in (("voltage", self.voltage, voltage), ("current", self.current, current)):
            if said is not None and stored is not None and not np.array_equal(said, stored):
                raise InputError(
                    f"{name} = {np.mean(said):g} {CHANNELS[name]} was given, but the file says "
                    f"{np.mean(stored):g} {CHANNELS[name]}; leave {name} out of the call"
                )
            found[name] = said if said is not None else stored
        return found


def read(
    path: str | Path,
    voltage: float | Array | None = None,
    current: float | Array | None = None,
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, str | int] | None = None,
) -> Record:
    """Read one test from a file; the suffix says which format it is.

    Parameters
    ----------
    path
        ``.mat`` (the campaign's MATLAB files), ``.csv`` and ``.txt`` (columns), ``.h5`` (dampyr's own).
    voltage, current
        The damper's input at the coil, V or A, where the file does not hold it.
    units
        Unit of each channel that the file does not state, such as ``{"displacement": "mm"}``.
    columns
        Name (or number, from 0) of the column of each channel, where the header's own words do not tell.

    Raises
    ------
    MissingData
        There is no such file.
    FileError
        The file is wrong: one line with the file, the value and the repair.
    """
    path = Path(path)
    known = catalogue.names(SHELF)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in known:
        raise FileError(path, f"the suffix {path.suffix!r} is not known; choose from {_suffixes(known)}")
    if not path.is_file():
        raise MissingData(f"{path}: there is no such file; check the path")
    try:
        request = Request(voltage, current, units or {}, columns or {})
        return catalogue.member(SHELF, kind).read(path, request)
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, str(problem)) from problem
    except OSError as problem:
        raise FileError(path, f"cannot be read ({_one_line(problem)}); check the file and its permissions") from problem


def write(record: Record, path: str | Path, **details: Any) -> Path:
    """Write ``record`` to ``path`` (.h5) whole or not at all, and return the path.

    ``details`` go to the format, such as ``raw`` for :func:`dampyr.records.formats.h5.write`.
    """
    path = Path(path)
    writable = [name for name, module in catalogue.members(SHELF) if hasattr(module, "write")]
    kind = path.suffix.lower().removeprefix(".")
    if kind not in writable:
        raise FileError(path, f"records are not written as {path.suffix!r}; choose from {_suffixes(writable)}")
    catalogue.member(SHELF, kind).write(record, path, **details)
    return path


def _suffixes(names: list[str]) -> str:
    return ", ".join(f".{name}" for name in names)


def _one_line(problem: BaseException) -> str:
    return " ".join(str(problem).split()) or type(problem).__name__
