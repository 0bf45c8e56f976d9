"""Reading and writing records: the suffix of the path picks the format."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from dampyr import registry
from dampyr.errors import DampyrWarning, FileError, InputError, MissingData
from dampyr.records.conditioning.integrated_displacement import INTEGRATED, is_integrated
from dampyr.records.conditioning.lowpass import as_lowpass, with_lowpass
from dampyr.records.conditioning.moving_average import Declaration
from dampyr.records.conditioning.nominal_input import agrees
from dampyr.records.conditioning.smoothing import with_smoothing
from dampyr.records.datasets import data_set_of_file
from dampyr.records.files.folder_metadata import KEYS, FolderReading, reading_of
from dampyr.records.record import CHANNELS, GROUPS, Array, Record, as_group
from dampyr.source_file import check_name, source_file

REGISTRY = "dampyr.records.formats"


class Layout(TypedDict, total=False):
    """What a file may leave unsaid besides its input, its units and its columns; see :func:`read`."""

    dt: float | str
    variable: str
    header: int
    force_sign: int
    measurement_session: str
    specimen: str
    smoothed: float | str | Mapping[str, Any] | Declaration
    lowpass: float | str


@dataclass(frozen=True)
class Request:
    """What is said about a file that it does not say itself; see :func:`read`. ``dt`` becomes s."""

    voltage: float | Array | None = None
    current: float | Array | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str | int | None] = field(default_factory=dict)
    dt: float | None = None
    variable: str | None = None
    header: int | None = None
    force_sign: int | None = None
    measurement_session: str | None = None
    specimen: str | None = None
    smoothed: Any = None
    lowpass: Any = None

    def __post_init__(self) -> None:
        for argument in ("units", "columns"):
            unknown = sorted(set(getattr(self, argument)) - set(CHANNELS))
            if unknown:
                raise InputError(
                    f"{argument} names {unknown[0]!r}, which is no channel; choose from {', '.join(CHANNELS)}"
                )
        for channel, column in self.columns.items():
            if isinstance(column, bool) or not isinstance(column, str | int | None):
                raise InputError(f"columns[{channel!r}] = {column!r} is no column; give its name, or its number from 0")
        for name in ("dt", "variable", "header", "force_sign"):
            if (said := getattr(self, name)) is not None:
                object.__setattr__(self, name, KEYS[name](name, said))
        for name in GROUPS:
            object.__setattr__(self, name, as_group(name, getattr(self, name)))
        if self.smoothed is not None:
            object.__setattr__(self, "smoothed", Declaration.of(self.smoothed))
        if self.lowpass is not None:
            object.__setattr__(self, "lowpass", as_lowpass(self.lowpass))

    def refuse(self, path: Path, **reasons: str) -> None:
        """Raise :class:`FileError` where something is said that a format cannot use: ``variable="a text has none"``."""
        for name, reason in reasons.items():
            if (said := getattr(self, name)) is not None:
                raise FileError(path, f"{name} = {said!r} was given, but {reason}; leave it out")

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
    *,
    dt: float | str | None = None,
    variable: str | None = None,
    header: int | None = None,
    force_sign: int | None = None,
    measurement_session: str | None = None,
    specimen: str | None = None,
    smoothed: float | str | Mapping[str, Any] | Declaration | None = None,
    lowpass: float | str | None = None,
) -> Record:
    """Read one test from a file; the suffix says which format it is.

    What is not said here is taken from the ``reading.toml`` beside the file, where there is one
    (:mod:`dampyr.records.files.folder_metadata`).

    Parameters
    ----------
    path
        such as ``.mat`` (MATLAB), ``.csv``, ``.txt`` and ``.dat`` (columns), ``.xlsx``, ``.tdms``,
        ``.h5`` (dampyr's own); each file of ``dampyr.records.formats`` is one format.
    voltage, current
        The damper's input at the coil, V or A, where the file does not hold it. A measured column of the file
        gives way to it where it agrees (to 5 %, or 0.05 V or A if that is more); else it is an error.
    units
        Unit of each channel that the file does not state, such as ``{"displacement": "mm"}``.
    columns
        Name (or number, from 0) of the column of each channel, where the header's own words do not tell; the name may have
        its unit, ``"Displacement (mm)"``. None, or "-", for a channel that is not to be read.
    dt
        The sampling interval of a file without a time, s or a text such as ``"2 ms"``.
    variable
        The matrix of a MATLAB file whose columns ``columns`` gives by number; the sheet of an Excel file; the group of channels
        of a TDMS file.
    header
        The line of a text on which the names stand, from 1; 0: there is none.
    force_sign
        -1 turns the force, for files in which a positive force does not oppose a positive velocity.
    measurement_session, specimen
        As in :class:`~dampyr.records.record.Record`; what a file says itself gives way, and the history says so.
    smoothed
        The moving average that the file's channels went through, such as ``0.3`` (s) or ``"0.1 periods, trailing, force"``
        (:class:`~dampyr.records.conditioning.moving_average.Declaration`): it is undone where it can be
        (:func:`~dampyr.records.conditioning.smoothing.with_smoothing`).
    lowpass
        The frequency in Hz, or ``"15 f"`` for 15 times that of the motion, above which the displacement is taken to be noise
        (:func:`~dampyr.records.conditioning.lowpass.with_lowpass`).

    A file with a velocity and no displacement is integrated
    (:func:`dampyr.records.conditioning.velocity.with_integrated_displacement`), with a warning.

    Raises
    ------
    MissingData
        There is no such file.
    FileError
        The file is wrong: one line with the file, the value and the repair.

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
    layout: dict[str, Any] = {"dt": dt, "variable": variable, "header": header, "force_sign": force_sign}
    layout |= {
        "measurement_session": measurement_session,
        "specimen": specimen,
        "smoothed": smoothed,
        "lowpass": lowpass,
    }
    record = read_file(Path(path), voltage=voltage, current=current, units=units, columns=columns, **layout)
    warn_of_integrated([record])
    return record


def read_file(path: Path, **said: Any) -> Record:
    """As :func:`read`, without its warning."""
    available = registry.names(REGISTRY)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in available:
        if not path.exists():
            raise MissingData(f"{path}: there is no such file or folder; check the path")
        raise FileError(path, f"the suffix {path.suffix!r} is not known; choose from {_suffixes(available)}")
    if not path.is_file():
        raise MissingData(f"{path}: there is no such file; check the path")
    check_name(path)
    try:
        metadata = reading_of(path.parent)
        request = _request(metadata, path, {name: value for name, value in said.items() if value is not None})
        record = _as_said(registry.member(REGISTRY, kind).read(path, request), request, metadata, path)
        source = source_file(path)
        dataset = data_set_of_file(source)
        published = (
            {"data_set": dataset.name, "doi": dataset.doi, "licence": dataset.licence_in_words} if dataset else {}
        )
        return replace(record, source_file=source, provenance=dict(record.provenance) | published)
    except FileError:
        raise
    except InputError as problem:
        raise FileError(path, str(problem)) from problem
    except OSError as problem:
        raise FileError(path, f"cannot be read ({_one_line(problem)}); check the file and its permissions") from problem


def warn_of_integrated(records: Iterable[Record]) -> None:
    """Warn, in one line, of records whose displacement was integrated from the velocity."""
    names = [record.name for record in records if is_integrated(record)]
    if names:
        which = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
        warnings.warn(
            f"{which}: displacement {INTEGRATED}; what became of its drift is in the notes and the history",
            DampyrWarning,
            stacklevel=3,
        )


def _request(metadata: FolderReading, path: Path, said: Mapping[str, Any]) -> Request:
    """What the caller says, and where it says nothing what ``reading.toml`` does."""
    of_folder = metadata.said_of(path, has_input="voltage" in said or "current" in said)
    both = {**of_folder, **said}
    for name in ("units", "columns"):
        both[name] = {**of_folder.get(name, {}), **said.get(name, {})}
    return Request(**both)


def _as_said(record: Record, request: Request, metadata: FolderReading, path: Path) -> Record:
    """The record with all that is said of it: sign of the force, moving average, low-pass, session, specimen, role."""
    if request.force_sign == -1:
        record = record.replace(note="force turned, as its sign was declared", force=-record.force)
    if request.smoothed is not None:
        record = with_smoothing(record, request.smoothed)
    if request.lowpass is not None:
        record = with_lowpass(record, request.lowpass)
    for name in GROUPS:
        said, stored = getattr(request, name), getattr(record, name)
        if said is not None and said != stored:
            instead = "" if stored is None else f", {stored!r} in the file"
            record = record.replace(note=f"{name} {said!r} as stated{instead}", **{name: said})
    if metadata.is_validation(path) and record.role != "validation":
        record = record.replace(note=f"role validation from {metadata.path.name}", role="validation")
    return record


def write(record: Record, path: str | Path, **details: Any) -> Path:
    """Write ``record`` to ``path`` (.h5, .csv, .mat, ...) whole or not at all, and return the path.

    ``details`` go to the format, such as ``raw`` for :func:`dampyr.records.formats.h5.write`.

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
