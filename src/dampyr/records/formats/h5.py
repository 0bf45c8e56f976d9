"""dampyr's own file, HDF5: one file per test, the raw readings beside the calibrated channels.

Layout (schema 3)::

    /            format = "dampyr record", schema = 3, complete = 0 or 1, name, role, test, try, sha256 (of every dataset,
                 `dampyr.records.files.checksums`), origin (`dampyr.origin`; dampyr up to 0.2.0 wrote none);
                 measurement_session and specimen where they are known; input = "none" where the damper has no input
    /calibrated  time, displacement, force, ...: (n,) float64 in SI, each with the attributes unit and units, as the conventions
                 of NetCDF call it; time is the dimension scale of the others, so that the group is a NetCDF of version 4
                 voltage or current as a number when it is constant; with the attributes uncertainty (one standard
                 uncertainty, in that unit) and uncertainty_parts (JSON) where it is stated
    /raw         one dataset per raw reading with the attributes unit, gain, offset, calibrated_unit:
                 calibrated = gain*raw + offset; empty for a test that was read from another format.
                 With an attribute delay [s] above 0, the calibrated value is that of so much earlier; with mass [kg]
                 and bandwidth [Hz], mass times the derivative of /calibrated/velocity at that bandwidth is taken off it.
    /label       peak_to_peak_m, frequency_hz, table, row (as attributes), where there is a label
    /smoothed    window [s], alignment, channels (as attributes), where channels hold a moving average that is not undone
    /repairs     one dataset per repair of samples (`dampyr.records.repair`), with the attributes kind, channels and words:
                 rows of the times, then of each channel before (NaN: no sample was there) and after
    /provenance  one attribute per entry
    /history     one string per step
    /marks       one sentence per fault that the recorder saw in the test, where there is one (`dampyr.campaigns.marks`)
    /rows        only while a test is recorded (`dampyr.records.files.recording`): how many samples are there; the
                 datasets are longer, and what lies beyond is nothing

In MATLAB: ``h5read("test.h5", "/calibrated/force")`` and ``h5readatt("test.h5", "/calibrated/force",
"unit")``; in GNU Octave ``s = load("test.h5")`` has ``s.calibrated.force``; in Python
``xarray.open_dataset("test.h5", group="calibrated", engine="h5netcdf", phony_dims="sort")``. A file whose writer was killed
says so: its ``complete`` is 0.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from dampyr.atomic_write import whole_file
from dampyr.channel_columns import OF_TEXTS
from dampyr.errors import FileError, InputError, one_line
from dampyr.input_kinds import NO_INPUT
from dampyr.models.numerics.differentiation import differentiate
from dampyr.origin import as_origin, of_board
from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.records.conditioning.moving_average import Alignment, MovingAverage
from dampyr.records.conditioning.repair_step import RepairStep
from dampyr.records.files.checksums import REPAIR, Attributes, Checksums, Stored, attributes_of
from dampyr.records.files.new_file import new_file
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.self_contained import check_contained
from dampyr.records.record import CHANNELS, GROUPS, MIN_SAMPLES, Label, Record, as_role
from dampyr.source_digest import full_version
from dampyr.units import to_si

TITLE, MEDIA_TYPE = "HDF5", "application/x-hdf5"
KEEPS_SMOOTHING = True  # as an attribute: a record may be smoothed and not undone
FORMAT = "dampyr record"
SCHEMA = 3  # the one that is written
SUPPORTED_SCHEMAS = (1, 2, 3)  # schema 1 had no /rows, 2 no dimension scales
PIECE = 2**16  # samples of a long record that are in memory at a time
UNCERTAINTY, UNCERTAINTY_PARTS = "uncertainty", "uncertainty_parts"  # attributes of a calibrated channel
RAW_OF = {"position": "displacement"}
"""The channel that a raw reading is calibrated to, where it has another name."""
RAW_ERROR = (
    1e-6  # of the largest value, or of the gain: rounding is 1e-10 of it, and one count or one bit of a converter 1
)


@dataclass(frozen=True)
class Raw:
    """A raw reading, ``(n,)`` volts or counts; gain*values + offset is the calibrated channel, ``delay`` s later, less the
    force of a ``mass`` [kg] times the derivative of the velocity at a ``bandwidth`` [Hz].

    To be written, the values may also be what is sliced like an array, such as a dataset of another file.
    """

    values: Any
    unit: str
    gain: float
    offset: float
    calibrated_unit: str
    delay: float = 0.0
    mass: float = 0.0
    bandwidth: float | None = None


class BrokenFile(FileError):
    """A file that is truncated or not HDF5 at all: nothing in it can be read."""


class FewSamples(FileError):
    """A file of a test that ended before it had enough ``samples`` for a record."""

    def __init__(self, path: Path, samples: int, why: str) -> None:
        count = f"{samples} sample{'s' * (samples != 1)}"
        super().__init__(
            path,
            f"holds {count} of a test that did not come to its end{f' ({why})' * bool(why)}, and a record needs {MIN_SAMPLES}; "
            "leave the file out",
        )
        self.samples = samples


@dataclass(frozen=True)
class FileState:
    """What a folder needs to know of a file: is it complete, of which test is it which try."""

    complete: bool
    test: str
    attempt: int


def read(path: Path, request: ReadOptions) -> Record:
    """The record in one of dampyr's files; an incomplete one says so in its provenance and history.

    Raises :class:`~dampyr.errors.FileError` where a dataset is not what was written, by its checksum or by the raw reading
    beside it, and its kind :class:`FewSamples` where the test ended too early for a record.
    """
    reason = "dampyr's own file says it itself"
    request.refuse(path, dt=reason, variable=reason, factors=reason, offsets=reason, **dict.fromkeys(OF_TEXTS, reason))
    with _open(path) as file:
        attributes = attributes_of(file)
        root = attributes["/"]
        stored, provenance = Stored(path, attributes), _texts_of(attributes.get("provenance", {}))
        _check_enough(path, file, provenance)
        channels = {
            name: _channel(path, file, name, request, stored, attributes)
            for name in CHANNELS
            if f"calibrated/{name}" in attributes
        }
        for name in ("time", "displacement", "force"):
            if name not in channels:
                raise FileError(path, f"/calibrated/{name} is missing; record the test again")
        texts = {name: _texts(file, name, stored) for name in ("history", "marks")}
        marks, history = texts["marks"], texts["history"]
        raw = _raw(file, attributes)
        difference = _difference_from_raw(channels, raw)
        if difference and _is_complete(file):
            raise FileError(path, f"{difference}; {REPAIR}")
        # Until 2026-11-23 a test that ended early said a delay that its displacement does not have.
        if difference and (difference := _difference_from_raw(channels, raw, delayed=False)):
            marks = (*marks, difference)
        replaced = request.replaced(channels.get("voltage"), channels.get("current"))
        channels |= request.input_channels(
            channels.pop("voltage", None), channels.pop("current", None), str(root.get("input", "")) == NO_INPUT
        )
        if not _is_complete(file) and provenance.get("complete") != "no":
            provenance["complete"] = "no"
            history = (*history, "read from a file whose recording was not completed")
        return Record(
            **channels,
            name=str(root["name"]),
            role=as_role(str(root["role"])),
            label=_label(attributes.get("label")),
            smoothed=_smoothed(attributes.get("smoothed")),
            repairs=_repairs(file, attributes, stored),
            provenance=provenance,
            history=(*history, *replaced),
            marks=marks,
            uncertainty=_uncertainty(path, attributes),
            # a file of dampyr up to 0.2.0 states no origin: its board tells
            origin=as_origin(str(root["origin"])) if "origin" in root else of_board(provenance.get("board", "")),
            **{name: str(root[name]) for name in GROUPS if name in root},  # type: ignore[arg-type]
        )


def _uncertainty(path: Path, attributes: Attributes) -> dict[str, ChannelUncertainty]:
    """The standard uncertainty of each channel that states it."""
    stated = {}
    for name in CHANNELS:
        text = attributes.get(f"calibrated/{name}", {}).get(UNCERTAINTY_PARTS)
        if text is None:
            continue
        unit = str(attributes[f"calibrated/{name}"].get("unit", "")) or CHANNELS[name]
        size = float(to_si(1.0, unit, CHANNELS[name]) - to_si(0.0, unit, CHANNELS[name]))
        try:
            stated[name] = ChannelUncertainty({part: size * value for part, value in json.loads(text).items()})
        except (ValueError, TypeError, AttributeError) as problem:
            raise FileError(
                path, f"/calibrated/{name} states no uncertainty that can be read ({problem}); {REPAIR}"
            ) from None
    return stated


def read_raw(path: str | Path) -> dict[str, Raw]:
    """The raw readings of a test with their calibration, by name."""
    with _open(Path(path)) as file:
        attributes = attributes_of(file)
        stored, raw = Stored(Path(path), attributes), _raw(file, attributes)
        for name, channel in raw.items():
            stored.check(f"raw/{name}", channel.values)
        return raw


def _raw(file: Any, attributes: Attributes) -> dict[str, Raw]:
    """The raw readings that say their calibration."""
    readings = {}
    for name, entries in attributes.items():
        if name.startswith("raw/") and entries.keys() >= {"unit", "gain", "offset", "calibrated_unit"}:
            gain, offset, delay = (float(entries.get(key, 0.0)) for key in ("gain", "offset", "delay"))
            unit, calibrated_unit = str(entries["unit"]), str(entries["calibrated_unit"])
            values = file[name][: _rows(file)]
            mass, bandwidth = float(entries.get("mass", 0.0)), entries.get("bandwidth")
            width = None if bandwidth is None else float(bandwidth)
            readings[name.removeprefix("raw/")] = Raw(values, unit, gain, offset, calibrated_unit, delay, mass, width)
    return readings


def _difference_from_raw(channels: Mapping[str, Any], raw: Mapping[str, Raw], delayed: bool = True) -> str:
    """A sentence on a channel that differs from its raw reading; empty where none does."""
    for name, reading in raw.items():
        channel = RAW_OF.get(name, name)
        values = channels.get(channel)
        if not isinstance(values, np.ndarray) or name == "time" or len(reading.values) != len(values):
            continue
        with np.errstate(over="ignore", invalid="ignore"):  # of a damaged reading
            expected = reading.gain * reading.values + reading.offset
        if reading.calibrated_unit != CHANNELS[channel]:
            expected = to_si(expected, reading.calibrated_unit, CHANNELS[channel])
        if reading.delay and delayed:
            expected = np.interp(channels["time"] - reading.delay, channels["time"], expected)
        if reading.mass and isinstance(channels.get("velocity"), np.ndarray):
            expected = expected - reading.mass * differentiate(
                channels["time"], channels["velocity"], reading.bandwidth
            )
        apart = np.abs(values - expected)
        size = float(np.abs(values[np.isfinite(values)]).max(initial=abs(reading.gain)))
        wrong = np.isfinite(values) & ~(apart <= RAW_ERROR * size)
        if wrong.any():
            worst = int(np.flatnonzero(wrong)[np.argmax(apart[wrong])])
            return (
                f"/calibrated/{channel} is not gain*raw + offset of /raw/{name}: they are "
                f"{apart[worst]:.4g} {CHANNELS[channel]} apart at {channels['time'][worst]:.4g} s"
            )
    return ""


def _check_enough(path: Path, file: Any, provenance: Mapping[str, str]) -> None:
    """Raise :class:`FewSamples` where an incomplete file holds too few samples for a record."""
    time = file.get("calibrated/time")
    rows = _rows(file) if "rows" in file else (len(time) if time is not None and time.shape else MIN_SAMPLES)
    if not _is_complete(file) and rows is not None and rows < MIN_SAMPLES:
        raise FewSamples(path, rows, provenance.get("reason", ""))


def _texts(file: Any, name: str, stored: Stored) -> tuple[str, ...]:
    texts = tuple(file[name].asstr()[()]) if name in file else ()
    stored.check(name, texts)
    return texts


def state(path: str | Path) -> FileState:
    """Whether the file is complete, and of which test it is which try."""
    with _open(Path(path)) as file:
        test = str(file.attrs.get("test", file.attrs["name"]))
        return FileState(_is_complete(file), test, int(file.attrs.get("try", 1)))


def provenance(path: str | Path) -> dict[str, str]:
    """Where a record comes from, without reading it."""
    with _open(Path(path)) as file:
        return _texts_of(file["provenance"].attrs) if "provenance" in file else {}


def write(record: Record, path: str | Path, raw: Mapping[str, Raw] | None = None) -> Path:
    """Write a record whole or not at all: to a file beside, synced, then put in its place in one move.

    A record whose provenance says ``complete: no`` stays marked incomplete; its entries ``test`` and ``try``
    (a whole number) say of which test of a campaign it is which try. Raises :class:`~dampyr.errors.InputError` where ``raw``
    does not give the record's channels.
    """
    path = Path(path)
    difference = _difference_from_raw({name: getattr(record, name) for name in CHANNELS}, raw or {})
    if difference:
        raise InputError(
            f"{record.name}: {difference}; give the readings and the calibration of this record, or no raw"
        )
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
        file.attrs.update({"format": FORMAT, "schema": SCHEMA, "written_by": f"dampyr {full_version()}"})
        first, until, sums = 0, -np.inf, Checksums()
        for record in pieces:
            if record.time[0] <= until:
                raise InputError(f"{record.name}: time {record.time[0]:g} s follows {until:g} s; it must rise")
            _fill_channels(file, n, first, record, sums)
            first, until = first + record.n, record.time[-1]
        _attach_time(file["calibrated"])
        _fill_raw(file, raw, sums)
        file.attrs.update({"name": record.name, "role": record.role, "origin": record.origin.kind})
        file.attrs.update({name: getattr(record, name) for name in GROUPS if getattr(record, name) is not None})
        if record.no_input:
            file.attrs["input"] = NO_INPUT
        file.attrs["test"] = record.provenance.get("test", record.name)
        file.attrs["try"] = int(record.provenance.get("try", "1"))
        if record.label is not None:
            fields = {k: v for k, v in vars(record.label).items() if v is not None}
            file.create_group("label").attrs.update(fields)
        if record.smoothed is not None:
            average = record.smoothed
            about = {"window": average.window, "alignment": average.alignment, "channels": ",".join(average.channels)}
            file.create_group("smoothed").attrs.update(about)
        for k, step in enumerate(record.repairs):
            _fill_repair(file, f"repairs/{k}", step, sums)
        file.create_group("provenance").attrs.update(dict(record.provenance))
        for name in ("history", "marks"):
            if texts := list(getattr(record, name)):
                file.create_dataset(name, data=texts, dtype=h5py.string_dtype())
                sums.add(name, texts)
        # The file has no name yet under which it is read, so that nothing sees it before it is whole.
        file.attrs["complete"] = np.uint8(record.provenance.get("complete") != "no")
        for channel, uncertainty in record.uncertainty.items():
            if (data := file.get(f"calibrated/{channel}")) is not None:
                about = {UNCERTAINTY: uncertainty.standard, UNCERTAINTY_PARTS: uncertainty.to_json()}
                data.attrs.update(about)
        sums.write(file)


def _fill_channels(file: Any, n: int, first: int, record: Record, sums: Checksums) -> None:
    for channel, unit in CHANNELS.items():
        if (values := getattr(record, channel)) is None:
            continue
        name = f"calibrated/{channel}"
        if name not in file:
            file.create_dataset(name, () if np.ndim(values) == 0 else (n,), "f8").attrs["unit"] = unit
        file[name][() if np.ndim(values) == 0 else slice(first, first + record.n)] = values
        if np.ndim(values) or not first:
            sums.add(name, np.asarray(values, "<f8"))


def _attach_time(group: Any) -> None:
    """The time as the dimension scale of the other channels, and units by the name that readers of NetCDF look for."""
    group["time"].make_scale("time")
    for name, data in group.items():
        data.attrs["units"] = data.attrs["unit"]
        if data.shape and name != "time":
            data.dims[0].attach_scale(group["time"])


def _fill_raw(file: Any, raw: Mapping[str, Raw], sums: Checksums) -> None:
    group = file.create_group("raw")
    for name, channel in raw.items():
        length = len(channel.values)
        data = group.create_dataset(name, (length,), channel.values.dtype)
        for first in range(0, length, PIECE):
            data[first : first + PIECE] = piece = channel.values[first : first + PIECE]
            sums.add(f"raw/{name}", piece)
        if not length:
            sums.add(f"raw/{name}", channel.values[:0])
        left_out = ("values", *(() if channel.mass else ("mass", "bandwidth")))
        attributes = {k: v for k, v in vars(channel).items() if k not in left_out}
        data.attrs.update(attributes)


@contextlib.contextmanager
def _open(path: Path) -> Any:
    """The open file, checked to hold all of its data and to be one of ours of a schema we know; every fault is a
    :class:`FileError`."""
    import h5py

    try:
        path.open("rb").close()
    except OSError as problem:
        raise FileError(
            path, f"cannot be read ({problem.strerror or problem}); check the file and its permissions"
        ) from problem
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
    except (OSError, KeyError, RuntimeError, TypeError, AttributeError, ValueError, SystemError) as problem:
        raise BrokenFile(
            path,
            f"is a truncated or broken HDF5 file ({one_line(problem)}); record or copy the test again (dampyr run has --again "
            "for it)",
        ) from problem


def _check_schema(path: Path, file: Any) -> None:
    file_format = str(file.attrs.get("format", ""))
    if file_format != FORMAT:
        raise FileError(path, f"is HDF5 but not a {FORMAT}: its format is {file_format!r}; export it as .csv")
    schema = int(file.attrs.get("schema", 0))
    if schema not in SUPPORTED_SCHEMAS:
        raise FileError(path, f"has the schema {schema}, this dampyr knows schema {SCHEMA}; upgrade dampyr")


def _texts_of(attributes: Mapping[str, Any]) -> dict[str, str]:
    return {name: str(value) for name, value in attributes.items()}


def _is_complete(file: Any) -> bool:
    return bool(file.attrs.get("complete", 0))


def _rows(file: Any) -> int | None:
    """How many samples are there, of a file whose recording has not ended; else None, which is all of them."""
    return int(file["rows"][()]) if "rows" in file else None


def _channel(path: Path, file: Any, name: str, request: ReadOptions, stored: Stored, attributes: Attributes) -> Any:
    data = file[f"calibrated/{name}"]
    unit = str(attributes[f"calibrated/{name}"].get("unit", "")) or request.units.get(name, "")
    if not unit:
        raise FileError(path, f"/calibrated/{name} has no unit; declare units={{{name!r}: {CHANNELS[name]!r}}}")
    if data.dtype.kind not in "fiu":
        raise FileError(path, f"/calibrated/{name} holds {data.dtype}, not real numbers; record or copy the test again")
    values = data[: _rows(file)] if data.shape else data[()]
    stored.check(f"calibrated/{name}", values)
    converted = values if unit == CHANNELS[name] else to_si(values, unit, CHANNELS[name])
    return float(converted) if np.ndim(converted) == 0 else converted


def _fill_repair(file: Any, name: str, step: RepairStep, sums: Checksums) -> None:
    """A repair as rows: time, then before and after of each channel."""
    rows = np.vstack([step.time, *(values for name in step.after for values in (step.before[name], step.after[name]))])
    file.create_dataset(name, data=rows).attrs.update(
        {"kind": step.kind, "channels": ",".join(step.after), "words": step.words}
    )
    sums.add(name, rows.astype("<f8"))


def _repairs(file: Any, attributes: Attributes, stored: Stored) -> tuple[RepairStep, ...]:
    steps = []
    for k in range(sum(name.startswith("repairs/") for name in attributes)):
        name, rows = f"repairs/{k}", file[f"repairs/{k}"][()]
        stored.check(name, rows)
        about, pairs = attributes[name], rows[1:].reshape(-1, 2, rows.shape[1])
        channels = dict(zip(str(about["channels"]).split(","), pairs, strict=True))
        before, after = ({channel: pair[row] for channel, pair in channels.items()} for row in (0, 1))
        steps.append(RepairStep(str(about["kind"]), rows[0], before, after, str(about["words"])))
    return tuple(steps)


def _smoothed(fields: Mapping[str, Any] | None) -> MovingAverage | None:
    if fields is None:
        return None
    return MovingAverage(
        float(fields["window"]), cast(Alignment, str(fields["alignment"])), tuple(str(fields["channels"]).split(","))
    )


def _label(fields: Mapping[str, Any] | None) -> Label | None:
    if fields is None:
        return None
    return Label(
        float(fields["peak_to_peak_m"]),
        float(fields["frequency_hz"]),
        str(fields.get("table", "")),
        int(fields["row"]) if "row" in fields else None,
    )
