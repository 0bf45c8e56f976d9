"""A test while it is recorded: a file in which a kill at any moment leaves every acknowledged sample readable.

All datasets lie in the file at their full length before the first sample comes, so that recording changes no structure of
the file: a block of samples is written into place, and then the number of rows, in one write of 8 bytes; both without the
HDF5 library. What is beyond that number is not there for any reader. At the end the file is written anew, as long as it
became, in one move, into room that was reserved before the first sample.
"""

from __future__ import annotations

import errno
import io
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.atomic_write import whole_file
from dampyr.errors import FileError, one_line
from dampyr.origin import NOT_STATED, Origin
from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.records.files.new_file import new_file, reserve
from dampyr.records.formats.h5 import FORMAT, PIECE, SCHEMA, Raw, fill
from dampyr.records.record import CHANNELS, GROUPS, Array, Label, Record, Role

ALL = slice(None)
UNFINISHED = ("kind", "delay", "mass", "bandwidth")  # of a raw channel: what a file under way does not say
SYNC_EVERY = 1.0  # s: what a power cut may take; each sync costs the disk a seek
STRUCTURE = 2**16  # bytes of a file besides samples and texts: 20 to 40 KiB were seen
REFUSALS = {
    errno.ENOSPC: ("the disk is full", "make room"),
    errno.EDQUOT: ("the quota on the disk is used up", "make room"),
    errno.EFBIG: ("a file may not become as long here", "raise that limit"),
}
Refine = Callable[[dict[str, Any]], dict[str, Any]]


@dataclass(frozen=True)
class RawChannel:
    """A raw reading and what makes SI of it: gain*raw + offset, in the finished file read ``delay`` s earlier, and less
    the inertia of ``mass`` [kg], of an acceleration of that ``bandwidth`` [Hz]."""

    unit: str
    gain: float
    offset: float
    calibrated_unit: str
    kind: str = "f8"
    delay: float = 0.0
    mass: float = 0.0
    bandwidth: float | None = None


@dataclass(frozen=True)
class RecordingHeader:
    """What is known of a test before it begins; ``constants`` are channels that are one number, ``derived`` those that only the
    finished file has."""

    name: str
    test: str
    attempt: int
    channels: tuple[str, ...]
    raw: Mapping[str, RawChannel]
    constants: Mapping[str, float] = field(default_factory=dict)
    role: Role = "fit"
    label: Label | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)
    derived: tuple[str, ...] = ()
    measurement_session: str | None = None
    specimen: str | None = None
    origin: Origin = NOT_STATED

    @property
    def groups(self) -> dict[str, str]:
        """The session and the specimen, as far as they are known."""
        return {name: getattr(self, name) for name in GROUPS if getattr(self, name) is not None}

    def file_sizes(self, rows: int) -> tuple[int, int]:
        """Bytes of the file under way and of the finished one, at most, with ``rows`` samples."""
        sample = 8 * len(self.channels) + sum(np.dtype(raw.kind).itemsize for raw in self.raw.values())
        texts = STRUCTURE + 2 * sum(
            len(str(text).encode()) for text in (*self.provenance.values(), *self.groups.values())
        )
        return rows * sample + texts, rows * (sample + 8 * len(self.derived)) + texts


class Recording:
    """A file under way. ``rows`` samples are acknowledged: they survive whatever happens to this process."""

    def __init__(self, path: str | Path, capacity: int, header: RecordingHeader) -> None:
        """Make the file with room for ``capacity`` samples, and reserve as much again for the copy that finishes it.

        Raises :class:`~dampyr.errors.FileError` where the disk has no space for both, or the file is there already.
        """
        self.path, self.capacity, self.header, self.rows = Path(path), capacity, header, 0
        self._synced = time.monotonic()
        with self._translate_errors("cannot be made", sum(header.file_sizes(capacity))), ExitStack() as undo:
            columns, rows = _create_file(self.path, capacity, header)
            undo.callback(self.path.unlink, missing_ok=True)
            self._file = undo.enter_context(self.path.open("rb+", buffering=0))
            self._data = {name: _Column(self._file, *place, self) for name, place in columns.items()}
            self._count = rows
            reserve(self._file.fileno(), os.fstat(self._file.fileno()).st_size)
            # without a name, so that a killed process leaves none of it
            self._copy = undo.enter_context(tempfile.TemporaryFile(dir=self.path.parent))
            reserve(self._copy.fileno(), header.file_sizes(capacity)[1])
            undo.pop_all()

    def append(self, values: Mapping[str, NDArray[Any]]) -> int:
        """Write a block, ``{"calibrated/force": (n,), "raw/force": (n,), ...}``; how many rows are acknowledged then."""
        n = len(next(iter(values.values())))
        if self.rows + n > self.capacity:
            raise FileError(
                self.path, f"has room for {self.capacity} samples, and {self.rows + n} came; plan it longer"
            )
        with self._translate_errors("cannot be written"):
            for name, data in self._data.items():
                data.write(self.rows, values[name])
            _write(self._file, self._count, np.uint64(self.rows + n).tobytes())
            if time.monotonic() - self._synced >= SYNC_EVERY:
                os.fsync(self._file.fileno())
                self._synced = time.monotonic()
        self.rows += n
        return self.rows

    @property
    def datasets(self) -> frozenset[str]:
        """The names of its datasets, such as ``raw/force``."""
        return frozenset(self._data)

    def read(self, name: str, rows: slice = ALL) -> Array:
        """Acknowledged samples of a dataset, such as ``calibrated/force``, all (rows,) or some of them."""
        begin, end, step = rows.indices(self.rows)
        length = max(step, PIECE // step * step)  # samples that are in memory at a time
        with self._translate_errors("cannot be read"):
            if step == 1:
                return self._data[name][begin:end]
            parts = [self._data[name][k : min(k + length, end)][::step] for k in range(begin, end, length)]
        return np.concatenate(parts)

    def close(self) -> None:
        """Leave the file as it is: incomplete, every acknowledged row in it."""
        self._copy.close()
        if not self._file.closed:
            with self._translate_errors("cannot be written"), self._file as file:
                os.fsync(file.fileno())

    def discard(self) -> None:
        """Remove the file of a test that never began: without a sample it is no try."""
        self.close()
        if not self.rows:
            self.path.unlink(missing_ok=True)

    def finish(
        self,
        provenance: Mapping[str, str],
        history: tuple[str, ...] = (),
        complete: bool = True,
        refine: Refine | None = None,
        margin: int = 0,
        marks: tuple[str, ...] = (),
        uncertainty: Mapping[str, ChannelUncertainty] | None = None,
        constants: Mapping[str, float] | None = None,
    ) -> Path:
        """Close the file and write it anew with what became known, whole or not at all, a piece of it at a time.

        Parameters
        ----------
        provenance, history
            Added to the header's provenance; the steps that the channels went through.
        complete
            Whether the test came to its end.
        refine
            Gives the channels of the finished file from those that were recorded; None leaves them as they are.
        margin
            Samples before and after each that ``refine`` looks at.
        marks, uncertainty
            The faults that were seen in the test, and the standard uncertainty of its channels.
        constants
            Replace those of the header.

        Raises
        ------
        FileError
            The finished file cannot be written; the recording stays readable as it is.
        """
        entries = dict(self.header.provenance) | dict(provenance)
        entries |= {"test": self.header.test, "try": str(self.header.attempt)} | (
            {} if complete else {"complete": "no"}
        )
        header = self.header
        common: dict[str, Any] = {
            "name": header.name,
            "label": header.label,
            "role": header.role,
            "origin": header.origin,
            "provenance": entries,
            "history": history,
            "uncertainty": dict(uncertainty or {}),
            "marks": marks,
            **header.groups,
            **header.constants,
            **(constants or {}),
        }
        # a channel that nothing refined is read when the raw reading is
        raw = {
            name: _raw(self._data[f"raw/{name}"], channel if refine else replace(channel, delay=0.0, mass=0.0))
            for name, channel in header.raw.items()
        }
        try:
            with self._translate_errors("cannot be finished"), whole_file(self.path) as temporary:
                self._copy.close()
                fill(temporary, self.rows, self._pieces(common, refine, margin), raw, header.file_sizes(self.rows)[1])
                self.close()
        finally:
            self.close()
        return self.path

    def _pieces(self, common: dict[str, Any], refine: Refine | None, margin: int) -> Iterator[Record]:
        count = max(1, self.rows // PIECE)
        for k in range(count):
            first, last = self.rows * k // count, self.rows * (k + 1) // count
            low, high = max(first - margin, 0), min(last + margin, self.rows)
            wide: dict[str, Any] = {name: self._data[f"calibrated/{name}"][low:high] for name in self.header.channels}
            channels = {name: v[first - low : last - low] for name, v in (refine(wide) if refine else wide).items()}
            yield Record(**channels, **common)

    @contextmanager
    def _translate_errors(self, what: str, needed: int = 0) -> Iterator[None]:
        """A refusal of the system as a sentence; ``needed`` bytes were to be reserved."""
        try:
            yield
        except (OSError, RuntimeError) as problem:
            number = getattr(problem, "errno", None) or 0
            if number in REFUSALS:
                raise FileError(self.path, f"{what}: {_refusal(number, needed, self.path.parent)}") from problem
            raise FileError(self.path, f"{what}: {one_line(problem)}") from problem


def check_disk_space(folder: Path, what: str, header: RecordingHeader, capacity: int) -> None:
    """Reserve the room for a recording and the copy that finishes it, and give it back.

    Raises :class:`~dampyr.errors.FileError` where the disk, a quota or the limit of a file's length does not allow it.
    """
    sizes = header.file_sizes(capacity)
    try:
        if sum(sizes) > shutil.disk_usage(folder).free:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        with ExitStack() as files:
            for size in sizes:
                reserve(files.enter_context(tempfile.TemporaryFile(dir=folder)).fileno(), size)
    except OSError as problem:
        if problem.errno in REFUSALS:
            why = _refusal(problem.errno, sum(sizes), folder)
        else:
            why = problem.strerror or str(problem)
        raise FileError(folder, f"{what} cannot be recorded: {why}") from problem


def _refusal(number: int, needed: int, folder: Path) -> str:
    """The reason for missing disk space, the space needed where that is known, and the repair."""
    free = shutil.disk_usage(folder).free
    sizes = (
        f": {needed} bytes are needed, a copy that finishes the record included, and {free} are free" if needed else ""
    )
    reason, repair = REFUSALS[number]
    return f"{reason}{sizes}; {repair}, and run the campaign again: it goes on with this test"


@dataclass(frozen=True)
class _Column:
    """A dataset of the file under way: its samples lie in one piece from ``first`` on."""

    file: io.FileIO
    first: int
    dtype: np.dtype[Any]
    recording: Recording

    def __len__(self) -> int:
        return self.recording.rows

    def __getitem__(self, some: slice) -> Array:
        begin, end, _ = some.indices(len(self))
        values = np.empty(max(0, end - begin), self.dtype)
        self.file.seek(self.first + begin * self.dtype.itemsize)
        left = _bytes(values)
        while left:
            count = self.file.readinto(left)
            if not count:
                raise OSError(f"it ends before its sample {end}")
            left = left[count:]
        return values

    def write(self, row: int, values: NDArray[Any]) -> None:
        """Put samples in their place, from ``row`` on."""
        data = np.ascontiguousarray(values, self.dtype)
        _write(self.file, self.first + row * self.dtype.itemsize, _bytes(data))


def _bytes(values: NDArray[Any]) -> memoryview:
    return values.data.cast("B") if values.size else memoryview(b"")


def _write(file: io.FileIO, place: int, data: bytes | memoryview) -> None:
    """All of it; :class:`OSError` where the disk takes less."""
    file.seek(place)
    left = memoryview(data)
    while left:
        left = left[file.write(left) :]


def _raw(values: _Column, channel: RawChannel) -> Raw:
    about = {
        name: getattr(channel, name)
        for name in ("unit", "gain", "offset", "calibrated_unit", "delay", "mass", "bandwidth")
    }
    return Raw(values, **about)


Place = tuple[int, "np.dtype[Any]"]


def _create_file(path: Path, capacity: int, header: RecordingHeader) -> tuple[dict[str, Place], int]:
    """The file with everything but samples, whole and synced before anyone sees it under its name.

    Where each dataset begins in it, with its type, and where the number of rows stands.
    """
    with whole_file(path, new=True) as temporary, new_file(temporary, libver="earliest") as file:
        file.attrs.update({"format": FORMAT, "schema": SCHEMA, "complete": np.uint8(0), "name": header.name})
        file.attrs["origin"] = header.origin.kind
        file.attrs.update({"role": header.role, "test": header.test, "try": header.attempt, **header.groups})
        for name in header.channels:
            _allocate_dataset(file, f"calibrated/{name}", capacity, "f8").attrs["unit"] = CHANNELS[name]
        for name, value in header.constants.items():
            file.create_dataset(f"calibrated/{name}", data=value).attrs["unit"] = CHANNELS[name]
        for name, channel in header.raw.items():
            attributes = {key: value for key, value in vars(channel).items() if key not in UNFINISHED}
            _allocate_dataset(file, f"raw/{name}", capacity, channel.kind).attrs.update(attributes)
        if header.label is not None:
            label_fields = {key: value for key, value in vars(header.label).items() if value is not None}
            file.create_group("label").attrs.update(label_fields)
        file.create_group("provenance").attrs.update(dict(header.provenance))
        rows = file.create_dataset("rows", data=np.uint64(0))
        names = [*(f"calibrated/{name}" for name in header.channels), *(f"raw/{name}" for name in header.raw)]
        columns = {name: (file[name].id.get_offset(), file[name].dtype) for name in names}
        return columns, rows.id.get_offset()


def _allocate_dataset(file: Any, name: str, capacity: int, kind: str) -> Any:
    """A dataset that lies in one piece at its full length from the beginning."""
    import h5py

    how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    how.set_layout(h5py.h5d.CONTIGUOUS)
    how.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    how.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    return file.create_dataset(name, (capacity,), kind, dcpl=how)
