"""Lock of a campaign's folder: one host at a time, by a lock of the operating system, which ends with its process.

The file ``campaign.lock`` names the holder for people; what counts is the lock on it, so that a file which a killed host has
left does not hold anybody off.
"""

from __future__ import annotations

import errno
import json
import os
import socket
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from dampyr.errors import DampyrWarning, FileError, InputError

NAME = "campaign.lock"
UNWRITABLE = (errno.EROFS, errno.EACCES, errno.EPERM)
BUSY = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK)
# Windows bars others from reading the bytes that are locked: one far beyond the text
LOCKED_BYTE = 2**30


_held: set[int] = set()  # descriptors of the locked files of this process


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Hold the folder; :class:`~dampyr.errors.InputError` says who holds it where somebody does.

    A folder that is read-only is not locked, since nothing is written there; one whose file system has no locks is used with
    a warning.
    """
    path = folder / NAME
    try:
        descriptor = _acquire(path)
    except OSError as problem:
        if problem.errno not in UNWRITABLE:
            raise FileError(
                path, f"cannot be made ({problem.strerror}); make room, or choose another folder"
            ) from problem
        yield
        return
    _held.add(descriptor)
    try:
        yield
    finally:
        with suppress(OSError):
            os.ftruncate(descriptor, 0)
            if sys.platform != "win32":  # which removes no open file
                path.unlink()
        _held.discard(descriptor)
        os.close(descriptor)


def _acquire(path: Path) -> int:
    """Lock the file; its descriptor."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            try:
                _lock(descriptor)
            except OSError as problem:
                if problem.errno in BUSY:
                    raise InputError(
                        f"{path.parent} is used by {_name_holder(path)}; wait, or give another --out"
                    ) from None
                warnings.warn(
                    f"{path.parent} cannot be locked ({problem.strerror}): see to it that no other host uses it",
                    DampyrWarning,
                    stacklevel=5,
                )
            if _is_current(descriptor, path):
                os.ftruncate(descriptor, 0)
                now = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
                holder = {"process": os.getpid(), "host": socket.gethostname(), "since": now}
                os.write(descriptor, json.dumps(holder).encode())
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # its holder has removed it in the meantime


def _lock(descriptor: int) -> None:
    """Take the lock now; :class:`OSError` where another has it."""
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, LOCKED_BYTE, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_current(descriptor: int, path: Path) -> bool:
    """Whether the locked file is still the one at ``path``: its former holder removes it as it lets go."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _name_holder(path: Path) -> str:
    """Who holds the lock, in words."""
    try:
        holder = json.loads(path.read_text("utf-8"))
        return f"another campaign: process {holder['process']} on {holder['host']}, since {holder['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another campaign"


def _release_in_child() -> None:
    """In a forked process: the lock is its parent's, and must not outlive it."""
    for descriptor in _held:
        with suppress(OSError):
            os.close(descriptor)
    _held.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_release_in_child)
