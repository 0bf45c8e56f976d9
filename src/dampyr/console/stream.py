"""The stream of a bench to one page: up to 22 frames a second, and no more than the page says that it has drawn.

From the page: ``{"heard": n}`` for frame n, ``{"jog": m/s}``, ``{"abort": anything}``, ``{"operator": name}`` of who works at
it, each a JSON object. To the page: frames
``{"frame": n, "next": bin, "strips": {name: [...]} or null, "state": {...} or null, "holds": whether this page has control}``,
``{"aborted": what was sent}`` as soon as the rig has braked and cut its coil, and ``{"refused": sentence}``.
"""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from dampyr.console.bench_session import Bench
from dampyr.console.clients import StreamTaken
from dampyr.console.decimation import as_lists
from dampyr.errors import InputError
from dampyr.to_json import plain

PERIOD = 0.045  # s between frames
STATE_EVERY = 3  # frames between two looks at the state
ALIVE = 12  # frames after which a page hears something even if nothing happens
TAKEN, CROWDED = 4410, 4409
"""Codes of a stream that is closed at once: another page is open by this id, or there are too many."""
MAX_OPERATOR = 200  # characters of a name
AHEAD = 6  # frames that a page may be behind
_NONE = object()  # no strips were looked at yet: what is past is asked for over HTTP
ABORTING = ThreadPoolExecutor(2, "abort")  # its own threads: nothing that is slow can stand before an abort


@dataclass
class Stream:
    """One page's end of the bench."""

    bench: Bench
    client: str
    socket: WebSocket
    sent: int = 0
    heard: int = 0
    bin: int = 0
    number: int = 0
    """Of the stream, among those of all clients."""
    _strips: Any = _NONE
    _state: str = ""
    _lock: asyncio.Lock = field(default_factory=asyncio.Lock)

    async def run(self) -> None:
        """Until the page is gone."""
        await self.socket.accept()
        try:
            self.number = self.bench.clients.join(self.client, self.socket.client.host if self.socket.client else "")
        except InputError as problem:
            await self.socket.close(TAKEN if isinstance(problem, StreamTaken) else CROWDED, str(problem)[:120])
            return
        talking = asyncio.create_task(self._talk())
        try:
            await self._listen()
        except (WebSocketDisconnect, RuntimeError):
            pass  # the page has gone: that is what this waits for
        finally:
            talking.cancel()
            self.bench.clients.disconnect(self.client, self.number)

    async def _listen(self) -> None:
        while True:
            message = _object(await self.socket.receive())
            if not self.bench.clients.knows(self.client, self.number):
                await self.socket.close(4408, "silent for too long")
                return
            self.bench.clients.hear(self.client)
            if "abort" in message:
                await self._abort(message["abort"])
            elif type(message.get("heard")) is int:
                self.heard = min(message["heard"], self.sent)
            elif "jog" in message:
                await self._jog(_speed(message["jog"]))
            elif type(message.get("operator")) is str:
                self.bench.clients.operate(self.client, message["operator"][:MAX_OPERATOR])

    async def _abort(self, sign: Any) -> None:
        name = self.bench.clients.who(self.client)
        await asyncio.get_running_loop().run_in_executor(ABORTING, self.bench.abort, name)
        await self._send({"aborted": sign})

    async def _jog(self, speed: float) -> None:
        try:
            self.bench.jog(self.client, speed)
        except InputError as problem:
            await self._send({"refused": str(problem)})

    async def _talk(self) -> None:
        ticks = 0
        while True:
            if self.sent - self.heard < AHEAD:
                await self._frame(ticks)
            ticks += 1
            await asyncio.sleep(PERIOD)

    async def _frame(self, ticks: int) -> None:
        """What is new; nothing is sent where nothing is."""
        strips, state = self._new_strips(), None
        if ticks % STATE_EVERY == 0:
            text = json.dumps(plain(self.bench.state()))
            if text != self._state or ticks % ALIVE == 0:
                self._state, state = text, json.loads(text)
        if strips is None and state is None:
            return
        self.sent += 1
        holds = self.bench.clients.holder == self.client
        await self._send({"frame": self.sent, "next": self.bin, "strips": strips, "state": state, "holds": holds})

    def _new_strips(self) -> dict[str, list[float | None]] | None:
        strips = self.bench.strips
        if strips is not self._strips:
            self._strips, self.bin = strips, strips.count if strips and self._strips is _NONE else 0
        if strips is None:
            return None
        self.bin, rows = strips.since(self.bin)
        return as_lists(rows) if len(rows) else None

    async def _send(self, message: dict[str, Any]) -> None:
        async with self._lock:
            await self.socket.send_text(json.dumps(message, separators=(",", ":")))


def _object(message: Mapping[str, Any]) -> dict[str, Any]:
    """What a page said; empty where it is not an object."""
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1006))
    try:
        parsed = json.loads(message.get("text") or "")
    except (ValueError, RecursionError):
        return {}
    return parsed if isinstance(parsed, dict) else {}


def _speed(value: Any) -> float:
    """m/s; what is not a number is 0: the table stops."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return 0.0
    try:
        return float(value)
    except OverflowError:
        return math.inf
