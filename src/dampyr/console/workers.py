"""Short work of requests in processes with limits: planning, listing and reading.

Whatever a file or a campaign unfolds to, the server's own memory and the bench's thread are not touched by it. A request waits
while others are answered; when the client leaves, its process is killed.
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from fastapi import HTTPException
from starlette.requests import Request

from dampyr.console.limits import RequestLimits
from dampyr.console.request_process import FORKED, answer
from dampyr.errors import InputError, MissingData
from dampyr.processes import ChildProcess

MAX_WAITING = 40  # requests: more is a page that repeats itself
EVERY = 0.2  # s between two looks whether the client is still there


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
        self.limits, self.ticket, self.begun = limits, ticket, False
        self.parts: list[Any] = []
        self._work = function, arguments
        self._child: ChildProcess | None = None
        self._cancelled = threading.Event()
        self._lock = threading.Lock()

    def cancel(self) -> None:
        """Nobody waits for it any more."""
        self._cancelled.set()
        with self._lock:
            if self._child is not None:
                self._child.kill()

    def serve(self) -> Any:
        """Start the process, wait for it, and return its result."""
        self.begun = True
        child = ChildProcess(answer, self.limits, *self._work, forked=FORKED)  # the first one waits for the imports
        try:
            with self._lock:
                self._child = child
            if self._cancelled.is_set():
                raise Withdrawn
            return self._result(child)
        finally:
            with self._lock:
                self._child = None
            child.kill()
            child.end()

    def _result(self, child: ChildProcess) -> Any:
        while True:
            message = self._receive(child)
            if "part" in message:
                self.parts.append(message["part"])
            elif "result" in message:
                return message["result"]
            elif "refused" in message:
                raise MissingData(message["refused"]) if message.get("missing") else InputError(message["refused"])
            else:
                raise RuntimeError("a process met an error of dampyr; its traceback stands above")

    def _receive(self, child: ChildProcess) -> dict[str, Any]:
        """The next message; why there is none where time or memory are used up, or the client has left."""
        (connection,) = child.connections
        try:
            if not connection.poll(self.limits.seconds):
                raise InputError(self.limits.too_long)
            return dict(json.loads(connection.recv_bytes()))
        except (EOFError, OSError):  # it has ended before
            if self._cancelled.is_set():
                raise Withdrawn from None
            raise InputError(self.limits.too_much) from None
