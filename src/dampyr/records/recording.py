"""A test while it is recorded: a file in which a kill at any moment leaves every acknowledged sample readable.

All datasets lie in the file at their full length before the first sample comes, so that recording changes no structure of the
file: a block of samples is written into place and flushed, and then the number of rows, in one write of 8 bytes. What
is beyond that number is not there for any reader. At the end the file is written anew, as long as it became, in one move.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FileError
from dampyr.records.formats.h5 import FORMAT, PIECE, SCHEMA, Raw, fill
from dampyr.records.record import CHANNELS, Array, Label, Record, Role
from dampyr.whole import whole_file

SYNC_EVERY = 1.0  # s
Refine = Callable[[dict[str, Any]], dict[str, Any]]


@dataclass(frozen=True)
class RawChannel:
    """A raw reading and what makes SI of it: gain*raw + offset, in the finished file read ``delay`` s earlier."""

    unit: str
    gain: float
    offset: float
    calibrated_unit: str
    kind: str = "f8"
    delay: float = 0.0


@dataclass(frozen=True)
class Header:
    """What is known of a test before it begins; ``constants`` are channels that are one number."""

    name: str
    test: str
    attempt: int
    channels: tuple[str, ...]
    raw: Mapping[str, RawChannel]
    constants: Mapping[str, float] = field(default_factory=dict)
    role: Role = "fit"
    label: Label | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)


class Recording:
    """A file under way. ``rows`` samples are acknowledged: they survive whatever happens to this process."""

    def __init__(self, path: str | Path, capacity: int, header: Header) -> None:
        """Make the file with room for ``capacity`` samples; :class:`FileError` where the disk has no room for them."""
        self.path, self.capacity, self.header, self.rows = Path(path), capacity, header, 0
        self._synced = time.monotonic()
        with self._told("cannot be made"):
            self._file = _made(self.path, capacity, header)
            self._fd: int = self._file.id.get_vfd_handle()
            _reserve(self._fd)
            self._data = {name: self._file[name] for name in _names(header)}
            self._count = self._file["rows"]

    def append(self, values: Mapping[str, NDArray[Any]]) -> int:
        """Write a block, ``{"calibrated/force": (n,), "raw/force": (n,), ...}``; how many rows are acknowledged then."""
        n = len(next(iter(values.values())))
        if self.rows + n > self.capacity:
            raise FileError(
                self.path, f"has room for {self.capacity} samples, and {self.rows + n} came; plan it longer"
            )
        with self._told("cannot be written"):
            for name, data in self._data.items():
                data[self.rows : self.rows + n] = values[name]
            self._file.flush()
            self._count[()] = self.rows + n
            self._file.flush()
            self._sync()
        self.rows += n
        return self.rows

    def _sync(self) -> None:
        if time.monotonic() - self._synced >= SYNC_EVERY:
            os.fsync(self._fd)
            self._synced = time.monotonic()

    def close(self) -> None:
        """Leave the file as it is: incomplete, every acknowledged row in it."""
        with self._told("cannot be written"):
            if self._file:
                os.fsync(self._fd)
                self._file.close()

    def finish(
        self,
        provenance: Mapping[str, str],
        history: tuple[str, ...] = (),
        complete: bool = True,
        refine: Refine | None = None,
        margin: int = 0,
    ) -> Path:
        """Close the file and write it anew with what became known, whole or not at all, a piece of it at a time.

        ``refine`` gives the channels that the finished file holds, from those that were recorded; it looks at ``margin``
        samples before and after each.
        """
        told = dict(self.header.provenance) | dict(provenance)
        told |= {"test": self.header.test, "try": str(self.header.attempt)} | ({} if complete else {"complete": "no"})
        header = self.header
        about: dict[str, Any] = {"name": header.name, "label": header.label, "role": header.role, **header.constants}
        about |= {"provenance": told, "history": history}
        raw = {name: _raw(_Rows(self._data[f"raw/{name}"], self.rows), c) for name, c in header.raw.items()}
        try:
            with self._told("cannot be finished"), whole_file(self.path) as beside:
                fill(beside, self.rows, self._pieces(about, refine, margin), raw)
                self.close()
        finally:
            self.close()
        return self.path

    def _pieces(self, about: dict[str, Any], refine: Refine | None, margin: int) -> Iterator[Record]:
        count = max(1, self.rows // PIECE)
        for k in range(count):
            first, last = self.rows * k // count, self.rows * (k + 1) // count
            low, high = max(first - margin, 0), min(last + margin, self.rows)
            wide = {name: self._data[f"calibrated/{name}"][low:high] for name in self.header.channels}
            channels = {name: v[first - low : last - low] for name, v in (refine(wide) if refine else wide).items()}
            yield Record(**channels, **about)

    @contextlib.contextmanager
    def _told(self, what: str) -> Any:
        try:
            yield
        except (OSError, RuntimeError) as problem:
            reason = " ".join(str(problem).split())
            if getattr(problem, "errno", None) == 28 or "No space left" in reason:
                reason = "the disk is full; make room, and run the campaign again: it goes on with this test"
            raise FileError(self.path, f"{what}: {reason}") from problem


class _Rows:
    """The rows of a dataset that are there."""

    def __init__(self, data: Any, rows: int) -> None:
        self.data, self.rows, self.dtype = data, rows, data.dtype

    def __len__(self) -> int:
        return self.rows

    def __getitem__(self, some: slice) -> Array:
        first, last, _ = some.indices(self.rows)
        return np.asarray(self.data[first:last])


def _raw(values: _Rows, channel: RawChannel) -> Raw:
    return Raw(values, channel.unit, channel.gain, channel.offset, channel.calibrated_unit, channel.delay)


def _names(header: Header) -> list[str]:
    return [*(f"calibrated/{name}" for name in header.channels), *(f"raw/{name}" for name in header.raw)]


def _made(path: Path, capacity: int, header: Header) -> Any:
    """The file with everything but samples, whole and synced before anyone sees it under its name."""
    import h5py

    with whole_file(path) as beside, h5py.File(beside, "w", libver="earliest") as file:
        file.attrs.update({"format": FORMAT, "schema": SCHEMA, "complete": np.uint8(0), "name": header.name})
        file.attrs.update({"role": header.role, "test": header.test, "try": header.attempt})
        for name in header.channels:
            _room(file, f"calibrated/{name}", capacity, "f8").attrs["unit"] = CHANNELS[name]
        for name, value in header.constants.items():
            file.create_dataset(f"calibrated/{name}", data=value).attrs["unit"] = CHANNELS[name]
        for name, channel in header.raw.items():
            told = {key: value for key, value in vars(channel).items() if key not in ("kind", "delay")}
            _room(file, f"raw/{name}", capacity, channel.kind).attrs.update(told)
        if header.label is not None:
            known = {key: value for key, value in vars(header.label).items() if value is not None}
            file.create_group("label").attrs.update(known)
        file.create_group("provenance").attrs.update(dict(header.provenance))
        file.create_dataset("rows", data=np.uint64(0))
    return h5py.File(path, "r+", libver="earliest", locking=False)


def _room(file: Any, name: str, capacity: int, kind: str) -> Any:
    """A dataset that lies in one piece at its full length from the beginning."""
    import h5py

    how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    how.set_layout(h5py.h5d.CONTIGUOUS)
    how.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    how.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    return file.create_dataset(name, (capacity,), kind, dcpl=how)


def _reserve(descriptor: int) -> None:
    """Take the room on the disk now, where the system can, so that it does not run out in the middle of a test."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(descriptor, 0, max(1, os.fstat(descriptor).st_size))
