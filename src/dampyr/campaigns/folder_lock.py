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
import weakref
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


class _Held:
    """A lock that this process holds."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor


_held: weakref.WeakSet[_Held] = weakref.WeakSet()


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Hold the folder; :class:`~dampyr.errors.InputError` says who holds it where somebody does.

    A folder that is read-only is not locked, since nothing is written there; one whose file system has no locks is used with
    a warning.
    """
    path = folder / NAME
    try:
        held = _Held(_acquired(path))
    except OSError as problem:
        if problem.errno not in UNWRITABLE:
            raise FileError(
                path, f"cannot be made ({problem.strerror}); make room, or choose another folder"
            ) from problem
        yield
        return
    _held.add(held)
    try:
        yield
    finally:
        with suppress(OSError):
            os.ftruncate(held.descriptor, 0)
            if sys.platform != "win32":  # which removes no open file
                path.unlink()
        _held.discard(held)
        os.close(held.descriptor)


def _acquired(path: Path) -> int:
    """The descriptor of the locked file."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            try:
                _lock(descriptor)
            except OSError as problem:
                if problem.errno in BUSY:
                    raise InputError(f"{path.parent} is used by {_holder(path)}; wait, or give another --out") from None
                warnings.warn(
                    f"{path.parent} cannot be locked ({problem.strerror}): see to it that no other host uses it",
                    DampyrWarning,
                    stacklevel=5,
                )
            if _is_current(descriptor, path):
                os.ftruncate(descriptor, 0)
                os.write(descriptor, _own_name().encode())
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
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _own_name() -> str:
    now = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
    return json.dumps({"process": os.getpid(), "host": socket.gethostname(), "since": now})


def _holder(path: Path) -> str:
    """Who holds the lock, in words."""
    try:
        name = json.loads(path.read_text("utf-8"))
        return f"another campaign: process {name['process']} on {name['host']}, since {name['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another campaign"


def _forget() -> None:
    """In a forked process: the lock is its parent's, and must not outlive it."""
    for held in list(_held):
        with suppress(OSError):
            os.close(held.descriptor)
    _held.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
