"""dampyr's own file, HDF5: one file per test, the raw readings beside the calibrated channels.

Layout (schema 2)::

    /            format = "dampyr record", schema = 2, complete = 0 or 1, name, role, test, try;
                 measurement_session and specimen where they are known
    /calibrated  time, displacement, force, ...: (n,) float64 in SI, each with the attribute unit
                 voltage or current as a number when it is constant
    /raw         one dataset per raw reading with the attributes unit, gain, offset, calibrated_unit:
                 calibrated = gain*raw + offset; empty for a test that was read from another format.
                 With an attribute delay [s] above 0, the calibrated value is that of so much earlier.
    /label       peak_to_peak_m, frequency_hz, table, row (as attributes), where there is a label
    /smoothed    window [s], alignment, channels (as attributes), where channels hold a moving average that is not undone
    /provenance  one attribute per entry
    /history     one string per step
    /rows        only while a test is recorded (`dampyr.records.recording`): how many samples are there; the
                 datasets are longer, and what lies beyond is nothing

In MATLAB: ``h5read("test.h5", "/calibrated/force")`` and ``h5readatt("test.h5", "/calibrated/force",
"unit")``. ``complete`` is set last, so a file whose writer was killed says so.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from dampyr.atomic_write import whole_file
from dampyr.errors import FileError, InputError
from dampyr.records.moving_average import Alignment, MovingAverage
from dampyr.records.new_file import new_file
from dampyr.records.record import CHANNELS, GROUPS, Label, Record, as_role
from dampyr.records.record_files import Request
from dampyr.records.self_contained import check_contained
from dampyr.units import to_si

TITLE, MEDIA_TYPE = "HDF5", "application/x-hdf5"
FORMAT = "dampyr record"
SCHEMA = 2  # the one that is written
SUPPORTED_SCHEMAS = (1, 2)  # schema 1 had no /rows
PIECE = 2**16  # samples of a long record that are in memory at a time


@dataclass(frozen=True)
class Raw:
    """A raw reading, ``(n,)`` volts or counts; gain*values + offset is the calibrated channel, ``delay`` s later.

    To be written, the values may also be what is sliced like an array, such as a dataset of another file.
    """

    values: Any
    unit: str
    gain: float
    offset: float
    calibrated_unit: str
    delay: float = 0.0


@dataclass(frozen=True)
class State:
    """What a folder needs to know of a file: is it complete, of which test is it which try."""

    complete: bool
    test: str
    attempt: int


def read(path: Path, request: Request) -> Record:
    """The record in one of dampyr's files; an incomplete one says so in its provenance and history."""
    own = "dampyr's own file says it itself"
    request.refuse(path, dt=own, variable=own, header=own)
    with _open(path) as file:
        channels = {name: _channel(path, file, name, request) for name in CHANNELS if f"calibrated/{name}" in file}
        for name in ("time", "displacement", "force"):
            if name not in channels:
                raise FileError(path, f"/calibrated/{name} is missing; record the test again")
        channels |= request.input_channels(channels.pop("voltage", None), channels.pop("current", None))
        provenance = _provenance(file)
        history = tuple(file["history"].asstr()[()]) if "history" in file else ()
        if not _is_complete(file) and provenance.get("complete") != "no":
            provenance["complete"] = "no"
            history = (*history, "read from a file whose recording was not completed")
        return Record(
            **channels,
            name=str(file.attrs["name"]),
            role=as_role(str(file.attrs["role"])),
            label=_label(file),
            smoothed=_smoothed(file),
            provenance=provenance,
            history=history,
            **{name: str(file.attrs[name]) for name in GROUPS if name in file.attrs},  # type: ignore[arg-type]
        )


def read_raw(path: str | Path) -> dict[str, Raw]:
    """The raw readings of a test with their calibration, by name."""
    with _open(Path(path)) as file:
        return {
            name: Raw(
                data[: _rows(file)],
                str(data.attrs["unit"]),
                float(data.attrs["gain"]),
                float(data.attrs["offset"]),
                str(data.attrs["calibrated_unit"]),
                float(data.attrs.get("delay", 0.0)),
            )
            for name, data in file["raw"].items()
        }


def state(path: str | Path) -> State:
    """Whether the file is complete, and of which test it is which try."""
    with _open(Path(path)) as file:
        test = str(file.attrs.get("test", file.attrs["name"]))
        return State(_is_complete(file), test, int(file.attrs.get("try", 1)))


def provenance(path: str | Path) -> dict[str, str]:
    """Where a record comes from, without reading it."""
    with _open(Path(path)) as file:
        return _provenance(file)


def write(record: Record, path: str | Path, raw: Mapping[str, Raw] | None = None) -> Path:
    """Write a record whole or not at all: to a file beside, synced, then put in its place in one move.

    A record whose provenance says ``complete: no`` stays marked incomplete; its entries ``test`` and ``try``
    (a whole number) say of which test of a campaign it is which try.
    """
    path = Path(path)
    try:
        with whole_file(path) as temporary:
            fill(temporary, record.n, [record], raw or {})
    except OSError as problem:
        raise FileError(
            path, f"cannot be written ({problem.strerror or problem}); make room, or choose another disk"
        ) from problem
    return path


def fill(path: Path, n: int, pieces: Iterable[Record], raw: Mapping[str, Raw], reserved_bytes: int = 0) -> None:
    """Write a record of ``n`` samples that comes in pieces; all but their channels is taken from the last.

    ``reserved_bytes`` are reserved before the first piece is asked for. Raises :class:`~dampyr.errors.InputError` where
    the clock of a piece does not go on from that of the last, :class:`OSError` where the disk is full.
    """
    import h5py

    with new_file(path, reserved_bytes) as file:
        file.attrs.update({"format": FORMAT, "schema": SCHEMA, "complete": np.uint8(0)})
        first, until = 0, -np.inf
        for record in pieces:
            if record.time[0] <= until:
                raise InputError(f"{record.name}: time {record.time[0]:g} s follows {until:g} s; it must rise")
            _fill_channels(file, n, first, record)
            first, until = first + record.n, record.time[-1]
        _fill_raw(file, raw)
        file.attrs.update({"name": record.name, "role": record.role})
        file.attrs.update({name: getattr(record, name) for name in GROUPS if getattr(record, name) is not None})
        file.attrs["test"] = record.provenance.get("test", record.name)
        file.attrs["try"] = int(record.provenance.get("try", "1"))
        if record.label is not None:
            fields = {k: v for k, v in vars(record.label).items() if v is not None}
            file.create_group("label").attrs.update(fields)
        if record.smoothed is not None:
            average = record.smoothed
            about = {"window": average.window, "alignment": average.alignment, "channels": ",".join(average.channels)}
            file.create_group("smoothed").attrs.update(about)
        file.create_group("provenance").attrs.update(dict(record.provenance))
        if record.history:
            file.create_dataset("history", data=list(record.history), dtype=h5py.string_dtype())
        file.flush()
        file.attrs["complete"] = np.uint8(record.provenance.get("complete") != "no")


def _fill_channels(file: Any, n: int, first: int, record: Record) -> None:
    for channel, unit in CHANNELS.items():
        if (values := getattr(record, channel)) is None:
            continue
        name = f"calibrated/{channel}"
        if name not in file:
            file.create_dataset(name, () if np.ndim(values) == 0 else (n,), "f8").attrs["unit"] = unit
        file[name][() if np.ndim(values) == 0 else slice(first, first + record.n)] = values


def _fill_raw(file: Any, raw: Mapping[str, Raw]) -> None:
    group = file.create_group("raw")
    for name, channel in raw.items():
        length = len(channel.values)
        data = group.create_dataset(name, (length,), channel.values.dtype)
        for first in range(0, length, PIECE):
            data[first : first + PIECE] = channel.values[first : first + PIECE]
        attributes = {k: v for k, v in vars(channel).items() if k != "values"}
        data.attrs.update(attributes)


@contextlib.contextmanager
def _open(path: Path) -> Any:
    """The open file, checked to hold all of its data and to be one of ours of a schema we know; every fault is a
    :class:`FileError`."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            check_contained(path, file)
            _check_schema(path, file)
            yield file
    except InputError:
        raise
    except MemoryError as problem:
        raise FileError(
            path, f"tells of more data than the memory holds ({problem}); record or copy the test again"
        ) from problem
    except (OSError, KeyError, RuntimeError, TypeError, AttributeError, ValueError) as problem:
        reason = " ".join(str(problem).split())
        raise FileError(
            path, f"is a truncated or broken HDF5 file ({reason}); record or copy the test again"
        ) from problem


def _check_schema(path: Path, file: Any) -> None:
    file_format = str(file.attrs.get("format", ""))
    if file_format != FORMAT:
        raise FileError(path, f"is HDF5 but no {FORMAT}: its format is {file_format!r}; export it as .csv")
    schema = int(file.attrs.get("schema", 0))
    if schema not in SUPPORTED_SCHEMAS:
        raise FileError(path, f"has the schema {schema}, this dampyr knows schema {SCHEMA}; upgrade dampyr")


def _provenance(file: Any) -> dict[str, str]:
    return {k: str(v) for k, v in file["provenance"].attrs.items()} if "provenance" in file else {}


def _is_complete(file: Any) -> bool:
    return bool(file.attrs.get("complete", 0))


def _rows(file: Any) -> int | None:
    """How many samples are there, of a file whose recording has not ended; else None, which is all of them."""
    return int(file["rows"][()]) if "rows" in file else None


def _channel(path: Path, file: Any, name: str, request: Request) -> Any:
    data = file[f"calibrated/{name}"]
    unit = str(data.attrs.get("unit", "")) or request.units.get(name, "")
    if not unit:
        raise FileError(path, f"/calibrated/{name} has no unit; declare units={{{name!r}: {CHANNELS[name]!r}}}")
    if data.dtype.kind not in "fiu":
        raise FileError(path, f"/calibrated/{name} holds {data.dtype}, not real numbers; record or copy the test again")
    values = data[: _rows(file)] if data.shape else data[()]
    converted = values if unit == CHANNELS[name] else to_si(values, unit, CHANNELS[name])
    return float(converted) if np.ndim(converted) == 0 else converted


def _smoothed(file: Any) -> MovingAverage | None:
    if "smoothed" not in file:
        return None
    fields = dict(file["smoothed"].attrs)
    return MovingAverage(
        float(fields["window"]), cast(Alignment, str(fields["alignment"])), tuple(str(fields["channels"]).split(","))
    )


def _label(file: Any) -> Label | None:
    if "label" not in file:
        return None
    fields = dict(file["label"].attrs)
    return Label(
        float(fields["peak_to_peak_m"]),
        float(fields["frequency_hz"]),
        str(fields.get("table", "")),
        int(fields["row"]) if "row" in fields else None,
    )
