"""Short work of requests in processes with limits: planning, listing and reading.

Whatever a file or a campaign unfolds to, the server's own memory and the bench's thread are not touched by it. A request waits
while others are answered; when the client leaves, its process is killed.
"""

from __future__ import annotations

import asyncio
import atexit
import contextlib
import json
import os
import pickle
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, BinaryIO

from fastapi import HTTPException
from starlette.requests import Request

from dampyr.console.limits import RequestLimits
from dampyr.console.worker_template import MAX_ANSWER
from dampyr.errors import InputError, MissingData

MAX_WAITING = 40  # requests: more is a page that repeats itself
EVERY = 0.2  # s between two looks whether the client is still there
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""A process that is forked may have no threads, and one that yields to a rig needs none."""


class Withdrawn(Exception):
    """The client has left; nobody reads the answer."""


class Workers:
    """A queue of requests, ``at_once`` of which have a process."""

    def __init__(self, at_once: int = 2) -> None:
        self._at_once = at_once
        self._threads: ThreadPoolExecutor | None = None
        self._orders: list[_Order] = []
        self._lock = threading.Lock()

    async def run(
        self,
        request: Request | None,
        limits: RequestLimits,
        function: Callable[..., Any],
        *arguments: Any,
        ticket: str = "",
    ) -> Any:
        """What ``function``, of a module, makes of ``arguments`` in a process with ``limits``, as JSON gives it.

        ``ticket`` is the name by which `position` tells how many are before it. Raises what ``function`` does of InputError and
        MissingData, and InputError where it passes a limit.
        """
        return await self._ordered(request, _Order(limits, function, arguments, ticket))

    async def each(
        self,
        request: Request | None,
        limits: RequestLimits,
        function: Callable[..., Any],
        items: list[Any],
        *arguments: Any,
    ) -> list[Any]:
        """What the generator ``function(items, *arguments)`` yields for each item; a refusal, an InputError, in the place of an
        item at which its process passes a limit. The others are then done by another process.
        """
        results: list[Any] = []
        while len(results) < len(items):
            order = _Order(limits, function, (items[len(results) :], *arguments), "")
            try:
                await self._ordered(request, order)
                results += order.parts
                break
            except InputError as problem:
                results += [*order.parts, problem]
        return results[: len(items)]

    def position(self, ticket: str) -> int | None:
        """How many requests are before that with this ticket; 0 while it is answered, None where there is none of that name."""
        with self._lock:
            waiting = [order.ticket for order in self._orders if not order.begun]
            if ticket in waiting:
                return waiting.index(ticket) + 1
            return 0 if any(order.ticket == ticket for order in self._orders) else None

    def close(self) -> None:
        """End all that is under way."""
        with self._lock:
            orders = list(self._orders)
        for order in orders:
            order.cancel()
        if self._threads is not None:
            self._threads.shutdown(wait=False, cancel_futures=True)
        self._threads = None

    async def _ordered(self, request: Request | None, order: _Order) -> Any:
        with self._lock:
            if len(self._orders) >= MAX_WAITING:
                raise HTTPException(503, f"{MAX_WAITING} requests are waiting already; wait for them, and try again")
            self._orders.append(order)
        leaving = None if request is None else asyncio.create_task(_cancel_when_left(request, order))
        try:
            with self._lock:  # the threads begin with the first order, and again where the console does
                if self._threads is None:
                    self._threads = ThreadPoolExecutor(self._at_once, thread_name_prefix="worker")
                future = self._threads.submit(order.serve)
            return await asyncio.wrap_future(future)
        except Withdrawn:
            raise HTTPException(503, "the request was withdrawn") from None
        finally:
            if leaving is not None:
                leaving.cancel()
            order.cancel()
            with self._lock:
                self._orders.remove(order)


async def _cancel_when_left(request: Request, order: _Order) -> None:
    while not await request.is_disconnected():
        await asyncio.sleep(EVERY)
    order.cancel()


class _Order:
    """One request to a process, and the process."""

    def __init__(
        self, limits: RequestLimits, function: Callable[..., Any], arguments: tuple[Any, ...], ticket: str
    ) -> None:
        self.limits, self.ticket, self.parts, self.begun = limits, ticket, [], False  # type: ignore[var-annotated]
        self._work = pickle.dumps((function, arguments, limits))
        self._child: _Child | None = None
        self._cancelled, self._late = threading.Event(), threading.Event()
        self._lock = threading.Lock()

    def cancel(self) -> None:
        """Nobody waits for it any more."""
        self._cancelled.set()
        self._kill()

    def _kill(self) -> None:
        with self._lock:
            if self._child is not None:
                self._child.kill()

    def _expire(self) -> None:
        self._late.set()
        self._kill()

    def serve(self) -> Any:
        """Start the process, wait for it, and return its result."""
        self.begun = True
        child = _start()
        try:
            with self._lock:
                self._child = child
            if self._cancelled.is_set():
                raise Withdrawn
            child.send(self._work)
            return self._result(child)
        finally:
            with self._lock:
                self._child = None
            child.close()

    def _result(self, child: _Child) -> Any:
        while True:
            timer = threading.Timer(self.limits.seconds, self._expire)
            timer.daemon = True
            timer.start()
            try:
                message = child.receive()
            finally:
                timer.cancel()
            if "part" in message:
                self.parts.append(message["part"])
            elif "result" in message:
                return message["result"]
            elif "refused" in message:
                raise MissingData(message["refused"]) if message.get("missing") else InputError(message["refused"])
            elif self._cancelled.is_set():
                raise Withdrawn
            elif "fault" in message:
                raise RuntimeError("a worker met an error of dampyr; its traceback stands above")
            else:
                raise InputError(self.limits.too_long if self._late.is_set() else self.limits.too_much)


class _Child:
    """A process of one request: its two streams, and how it is ended."""

    def __init__(self, reading: BinaryIO, writing: BinaryIO, process: subprocess.Popen[bytes] | None) -> None:
        self._reading, self._writing, self._process, self._pidfd = reading, writing, process, -1
        pid = self.receive().get("pid")
        if process is None and pid is not None:
            with contextlib.suppress(OSError):  # it has ended already
                self._pidfd = os.pidfd_open(pid)

    def send(self, work: bytes) -> None:
        with contextlib.suppress(OSError):  # it has ended, which its silence tells
            self._writing.write(struct.pack(">Q", len(work)) + work)
            self._writing.flush()

    def receive(self) -> dict[str, Any]:
        """The next message; empty where the process has ended."""
        try:
            line = self._reading.readline(MAX_ANSWER + 2)
            return dict(json.loads(line)) if line.endswith(b"\n") else {}
        except (OSError, ValueError):
            return {}

    def kill(self) -> None:
        with contextlib.suppress(OSError):
            if self._process is not None:
                self._process.kill()
            elif self._pidfd >= 0:
                signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)

    def close(self) -> None:
        self.kill()
        for stream in (self._reading, self._writing):
            with contextlib.suppress(OSError):
                stream.close()
        if self._process is not None:
            self._process.wait()
        if self._pidfd >= 0:
            os.close(self._pidfd)


def _start() -> _Child:
    if sys.platform != "linux":
        command = [sys.executable, "-m", "dampyr.console.worker_template", "-"]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=os.environ | ONE_THREAD)
        assert process.stdout is not None
        assert process.stdin is not None
        return _Child(process.stdout, process.stdin, process)  # type: ignore[arg-type]
    ours, theirs = socket.socketpair()
    with ours, theirs:
        _template.hand_over(theirs)
        theirs.close()  # or its end is never seen
        return _Child(ours.makefile("rb"), ours.makefile("wb"), None)


class _Template:
    """The process from which others are forked, one for each server; started with the first request."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._control: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Begin to import what processes need."""
        with self._lock:
            self._started()

    def hand_over(self, link: socket.socket) -> None:
        """Fork a process for ``link``."""
        with self._lock:
            for _ in range(2):  # again with another one, where the first has been killed
                try:
                    socket.send_fds(self._started(), [b"1"], [link.fileno()])
                    return
                except OSError:
                    self._control = None
        raise RuntimeError("the process that answers requests cannot be started")

    def _started(self) -> socket.socket:
        if self._control is None:
            if self._process is not None:
                self._process.kill()
                self._process.wait()
            self._control, theirs = socket.socketpair()
            command = [sys.executable, "-m", "dampyr.console.worker_template", str(theirs.fileno())]
            with theirs:
                self._process = subprocess.Popen(
                    command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, start_new_session=True,
                    env=os.environ | ONE_THREAD,
                )  # fmt: skip
        return self._control

    def close(self) -> None:
        """End it; those that it forked end with their requests."""
        with self._lock:
            if self._control is not None:
                self._control.close()
            if self._process is not None:
                self._process.kill()
                self._process.wait()
            self._control = self._process = None


_template = _Template()
atexit.register(_template.close)
preload = _template.start
"""Begin to import, so that the first request does not wait for it."""
