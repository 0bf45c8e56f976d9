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

from filelock import FileLock, Timeout

from dampyr.errors import DampyrWarning, FileError, InputError

NAME = "campaign.lock"
UNWRITABLE = (errno.EROFS, errno.EACCES, errno.EPERM)
NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EINVAL)
PATIENCE = 0.05  # s: long enough for a holder that lets go and removes the file meanwhile


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Hold the folder; :class:`~dampyr.errors.InputError` says who holds it where somebody does.

    A folder that is read-only is not locked, since nothing is written there; one whose file system has no locks is used with
    a warning.
    """
    path = folder / NAME

    def name_holder(descriptor: int) -> None:
        if not (path.exists() and os.path.samestat(os.fstat(descriptor), path.stat())):
            raise Timeout(str(path))  # its former holder has removed it, which its number of links does not tell on NFS
        now = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
        holder = {"process": os.getpid(), "host": socket.gethostname(), "since": now}
        os.ftruncate(descriptor, 0)
        os.write(descriptor, b"\n" + json.dumps(holder).encode())  # on Windows others cannot read the first byte

    lock = FileLock(
        path, PATIENCE, thread_local=False, poll_interval=PATIENCE / 10, fallback_to_soft=False, on_acquired=name_holder
    )
    try:
        folder.stat()  # or it would be made
        lock.acquire()
    except Timeout:
        raise InputError(f"{folder} is used by {_holder(path)}; wait, or give another --out") from None
    except OSError as problem:
        if problem.errno in NO_LOCKS:
            with suppress(OSError):
                path.unlink()
            warnings.warn(
                f"{folder} cannot be locked ({problem.strerror}): see to it that no other host uses it",
                DampyrWarning,
                stacklevel=3,
            )
        elif problem.errno not in UNWRITABLE or os.access(path, os.W_OK):  # filelock has reasons of its own
            raise FileError(
                path, f"cannot be made ({problem.strerror}); make room, or choose another folder"
            ) from problem
    try:
        yield
    finally:
        if lock.is_locked and sys.platform != "win32":  # where filelock removes it
            with suppress(OSError):
                path.unlink()  # while it is held: who has opened it sees that it is gone
        lock.release()


def _holder(path: Path) -> str:
    """Who holds the lock, in words."""
    try:
        with path.open("rb") as file:
            file.seek(1)
            holder = json.loads(file.read())
        return f"another campaign: process {holder['process']} on {holder['host']}, since {holder['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another campaign"
