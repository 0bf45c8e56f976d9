"""The pages that watch the bench, and the one that holds control: visible to all, taken over only explicitly."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field

from dampyr.errors import InputError

SILENCE = 3.0  # s after which a client that says nothing has vanished
MAX_CLIENTS = 16  # pages: each costs the bench up to 22 frames a second


class StreamTaken(InputError):
    """A page asks by the id of another one that is open: its tab was duplicated, or its own last stream is not closed yet."""


@dataclass
class _Client:
    name: str
    stream: int
    heard: float
    address: str = ""
    operator: str = ""


@dataclass
class Clients:
    """The clients by their ids; ``clock`` gives s."""

    clock: Callable[[], float]
    holder: str | None = None
    _clients: dict[str, _Client] = field(default_factory=dict)
    _numbered: int = 0
    _lock: threading.RLock = field(default_factory=threading.RLock)

    def __post_init__(self) -> None:
        self.alone_since: float | None = self.clock()

    def join(self, client: str, address: str = "") -> int:
        """A client at ``address`` opens a stream, whose number this is; it gets control where nobody has it.

        One client has one stream: two pages that hold control by one id would each believe that it is theirs.
        """
        with self._lock:
            if client in self._clients:
                raise StreamTaken("another page is open under this one's id; it opens under one of its own")
            if len(self._clients) >= MAX_CLIENTS:
                raise InputError(f"{MAX_CLIENTS} pages look at the bench already; close one of them")
            self._numbered += 1
            self._clients[client] = _Client(f"page {self._numbered}", self._numbered, self.clock(), address)
            self.alone_since, self.holder = None, self.holder or client
            return self._numbered

    def hear(self, client: str) -> None:
        """A client says that it lives."""
        with self._lock:
            if client in self._clients:
                self._clients[client].heard = self.clock()

    def disconnect(self, client: str, stream: int | None = None) -> bool:
        """A client closes its stream, that of a number if one is given; whether it lost control by that."""
        with self._lock:
            return self.knows(client, stream) and self._forget(client)

    def silent(self) -> bool:
        """Forget who has said nothing for `SILENCE`; whether the holder of control was among them."""
        with self._lock:
            late = [client for client, entry in self._clients.items() if self.clock() - entry.heard > SILENCE]
            lost = [client for client in late if self._forget(client)]
            return bool(lost)

    def take(self, client: str) -> None:
        """Take control, from whoever has it."""
        with self._lock:
            self._require_stream(client)
            self.holder = client

    def require(self, client: str) -> None:
        """Raise :class:`~dampyr.errors.InputError` where ``client`` does not hold control."""
        with self._lock:
            self._require_stream(client)
            if self.holder is None:
                raise InputError("nobody holds control; take control first")
            if self.holder != client:
                raise InputError(f"{self.name(self.holder)} holds control; take control first")

    def name(self, client: str | None) -> str:
        """How others see a client; empty for none."""
        with self._lock:
            return self._clients[client].name if client in self._clients else ""

    def operate(self, client: str, operator: str) -> None:
        """``operator`` works at this page from now on; nothing changes without a name."""
        with self._lock:
            if client in self._clients and operator.strip():
                self._clients[client].operator = operator.strip()

    def who(self, client: str | None) -> str:
        """Who does what a client asks for: its operator and the page, or the page and its address; empty for none."""
        with self._lock:
            entry = self._clients.get(client or "")
            unnamed = entry is not None and entry.address and not entry.operator
            return f"{self.titled(client)} from {entry.address}" if entry and unnamed else self.titled(client)

    def titled(self, client: str | None) -> str:
        """How a page calls a client: its operator, where one was named, and the page; empty for none."""
        with self._lock:
            entry = self._clients.get(client or "")
            return "" if entry is None else ", ".join(filter(None, (entry.operator, entry.name)))

    def knows(self, client: str, stream: int | None = None) -> bool:
        """Whether a client has an open stream, that of a number if one is given."""
        with self._lock:
            entry = self._clients.get(client)
            return entry is not None and stream in (None, entry.stream)

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self._clients)

    @property
    def alone(self) -> float:
        """s since the last client left; 0 while there is one."""
        since = self.alone_since
        return 0.0 if since is None else self.clock() - since

    def _require_stream(self, client: str) -> None:
        if client not in self._clients:
            raise InputError("this page has no open stream, so it cannot hold control; reload it")

    def _forget(self, client: str) -> bool:
        del self._clients[client]
        if not self._clients:
            self.alone_since = self.clock()
        if self.holder != client:
            return False
        self.holder = None
        return True
