"""Processes of dampyr's own: one that reads a rig, one that answers a request of a page, one that does a job.

Each calls a function of a module with its ends of pipes (`multiprocessing.connection`), over which both sides send what can be
pickled. None outlives the process that started it: where that ends, whatever the reason, its ends of the pipes are closed,
which the function sees as the end of the file (`end_with`).
"""

from __future__ import annotations

import atexit
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import forkserver, get_context
from multiprocessing.connection import Connection
from multiprocessing.connection import wait as wait_for
from types import ModuleType
from typing import Any, cast
from weakref import WeakSet

from dampyr.errors import DampyrError, one_line

FORKS = sys.platform == "linux"  # elsewhere a process that is forked after libraries were loaded may crash
PAUSES = 0.1, 1.0  # s in which a process that was killed gives back its memory, and is gone
PATIENCE = 3.0  # s in which a process that is asked to end does so

_lock = threading.RLock()  # multiprocessing looks after all children whenever it starts or joins one
_running: WeakSet[ChildProcess] = WeakSet()


class ChildProcess:
    """``function(*pipes, *arguments)`` in a process of its own, in a session of its own: a Ctrl-C is for this process.

    ``function`` is one of a module, and ``arguments`` can be pickled; the main script is not run again in the process, so that
    it needs no ``if __name__ == "__main__"``. ``connections`` are the ends of its ``pipes`` pipes on this side. With ``forked``
    it is a copy of a process that has imported the module of that name, which takes milliseconds (`begin_to_import`); without,
    or where the system cannot, an interpreter is started for it, which takes a second. Raises
    :class:`~dampyr.errors.DampyrError` where the system starts none.
    """

    def __init__(self, function: Callable[..., object], *arguments: object, pipes: int = 1, forked: str = "") -> None:
        if forked:
            begin_to_import(forked)
        context = cast(Any, get_context("forkserver" if forked and FORKS else "spawn"))
        pairs = [context.Pipe() for _ in range(pipes)]
        self.connections: list[Connection] = [ours for ours, _ in pairs]
        theirs = [end for _, end in pairs]
        self._process = context.Process(target=_begin, args=(function, theirs, arguments))
        try:
            self._start()
        except BaseException:
            self.hang_up()
            raise
        finally:
            for end in theirs:  # or the end of the process would not be seen here
                end.close()
        self.pid: int = self._process.pid
        _running.add(self)

    def _start(self) -> None:
        for pause in (*PAUSES, None):
            try:
                with _lock, _without_main():
                    self._process.start()
                return
            except (EOFError, OSError) as problem:
                # such as where the process to be copied was killed, which is started again once it is gone
                if pause is None:
                    raise DampyrError(f"a process was not started ({one_line(problem)}); try again") from problem
                time.sleep(pause)

    def wait(self, seconds: float | None = None) -> int | None:
        """The exit status, once it has ended; None where that takes more than ``seconds``. That of a killed one is negative."""
        if not wait_for([self._process.sentinel], seconds):
            return None
        with _lock:
            self._process.join()
        status: int = self._process.exitcode
        return status

    def kill(self) -> None:
        """End it now, with all that it has started; from any thread, without waiting."""
        if not wait_for([self._process.sentinel], 0.0):
            _kill(self.pid)

    def hang_up(self) -> None:
        """Shut the pipes down, from any thread, which asks it to end."""
        for end in self.connections:
            if os.name != "posix":
                end.close()
            elif not end.closed:  # one that is closed stays open for as long as a thread waits at it
                with suppress(OSError), socket.socket(fileno=os.dup(end.fileno())) as pipe:
                    pipe.shutdown(socket.SHUT_RDWR)

    def end(self, patience: float = PATIENCE) -> None:
        """Have it end: asked, and killed where it has not ended after ``patience`` [s]. Nothing may wait at its pipes then."""
        self.hang_up()
        if self.wait(patience) is None:
            self.kill()
            self.wait()
        for end in self.connections:
            end.close()


def begin_to_import(module: str) -> None:
    """Start the process that imports ``module`` and is copied then; this process has one, with its first ``module``."""
    if FORKS:
        with _lock:
            get_context("forkserver").set_forkserver_preload([module])
            forkserver.ensure_running()


def end_with(connection: Connection) -> None:
    """End this process, and all that it starts, as soon as the other end of ``connection`` is closed; nothing comes over it."""

    def watch() -> None:
        with suppress(OSError):
            connection.poll(None)
        _kill(os.getpid())

    threading.Thread(target=watch, name="end with the other process", daemon=True).start()


def _begin(function: Callable[..., object], connections: list[Connection], arguments: tuple[object, ...]) -> None:
    if os.name == "posix":
        os.setsid()
    function(*connections, *arguments)


def _kill(pid: int) -> None:
    """Kill a process of `ChildProcess`, and what it has started where the system knows that by its session."""
    if os.name != "posix":
        with suppress(OSError):
            os.kill(pid, signal.SIGTERM)  # which ends it without a word
        return
    try:
        os.killpg(pid, signal.SIGKILL)
    except ProcessLookupError:  # it has ended, or has no session yet
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


@contextmanager
def _without_main() -> Iterator[None]:
    """multiprocessing runs the main script in each process, for functions that stand there; these stand in modules."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@atexit.register
def _hang_up_all() -> None:
    """At the end of this process: multiprocessing waits then for every process that it has started."""
    for child in list(_running):
        child.hang_up()
