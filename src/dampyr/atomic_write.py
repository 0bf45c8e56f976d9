"""A file is written whole or not at all: a kill at any moment leaves the old one or the new one."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dampyr.errors import FileError


@contextmanager
def whole_file(path: Path, new: bool = False) -> Iterator[Path]:
    """A file beside ``path`` to be written; afterwards synced and put in its place in one move, or removed on an error.

    Raises :class:`~dampyr.errors.FileError` where the folder is missing or takes no file, and with ``new`` where ``path`` is
    there already: then nothing is replaced, whoever made it and when.
    """
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
        os.close(handle)
    except OSError as problem:
        raise FileError(
            path, f"cannot be written ({problem.strerror}); choose a folder that exists and can be written to"
        ) from problem
    temporary = Path(name)
    try:
        yield temporary
        with temporary.open("rb+") as written:
            os.fsync(written.fileno())
        temporary.chmod(0o644)
        if new:
            _place_new(temporary, path)
        else:
            temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    _sync_folder(path.parent)


def write_whole(path: Path, text: str) -> None:
    """Write ``text`` in UTF-8, with line feeds, as a `whole_file`."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def _place_new(temporary: Path, path: Path) -> None:
    """Give the file its name, unless another has it."""
    try:
        try:
            os.link(temporary, path)
        except FileExistsError:
            raise
        except OSError:  # a file system without links
            if path.exists():
                raise FileExistsError from None
            temporary.rename(path)
        temporary.unlink(missing_ok=True)
    except FileExistsError:
        raise FileError(
            path, "is there already, and nothing is written over it; move it away, or choose another name"
        ) from None


def _sync_folder(folder: Path) -> None:
    """Make the move durable, where the system can sync a folder."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
