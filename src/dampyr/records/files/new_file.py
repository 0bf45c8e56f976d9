"""A new HDF5 file that is written through Python's own files, so that a full disk is an error and nothing worse.

The HDF5 library does not survive a write that fails: it keeps what it could not write, tries again whenever anything of the
file is closed, and ends the process with a segmentation fault. So it never sees one here: after the first write that the
system refuses the others are dropped, and the error is raised when the library has let go of the file.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def new_file(path: Path, reserved_bytes: int = 0, **how: Any) -> Iterator[Any]:
    """An open `h5py.File` that takes the place of what is in ``path``; ``reserved_bytes`` are reserved before it is begun.

    ``how`` goes to `h5py.File`. Raises :class:`OSError` where the disk has not the room, or refuses a write.
    """
    import h5py

    with _Output(path) as output:
        if reserved_bytes:
            reserve(output.fileno(), reserved_bytes)
        try:
            with h5py.File(output, "w", **how) as file:
                yield file
        finally:
            if output.refused is not None:
                raise output.refused
        output.shorten()


def reserve(descriptor: int, size: int) -> None:
    """Take room for ``size`` bytes on the disk now, where the system can; :class:`OSError` where there is not so much."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(descriptor, 0, max(1, size))


class _Output(io.FileIO):
    """What h5py writes to. The file on the disk may be longer than what was written, until it is shortened."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self.end, self.refused = 0, None  # type: int, OSError | None

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """As of a file that ends where the library has written or truncated it."""
        return super().seek(self.end + offset) if whence == os.SEEK_END else super().seek(offset, whence)

    def readinto(self, buffer: Any) -> int:
        """What was never written reads as zeros."""
        view = memoryview(buffer).cast("B")
        count = super().readinto(view) or 0
        view[count:] = bytes(len(view) - count)
        return len(view)

    def write(self, data: Any) -> int:
        """All of it, unless a write was refused."""
        view = memoryview(data).cast("B")
        self.end = max(self.end, self.tell() + len(view))
        try:
            left = view
            while self.refused is None and left:
                left = left[super().write(left) :]
        except OSError as problem:
            self.refused = problem
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """The library says how long the file is; what is reserved beyond is given back at the end."""
        self.end = self.tell() if size is None else size
        return self.end

    def shorten(self) -> None:
        """Give back what was reserved and not written."""
        super().truncate(self.end)
