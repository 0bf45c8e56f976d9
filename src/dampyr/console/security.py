"""Access control: Host, Origin and token of every request and WebSocket, the size of requests, and what a page may load.

A page of another site can make a browser send requests here. It cannot choose their Host (so a foreign name that resolves to
this machine is refused), nor hide their Origin (so a request or a WebSocket from another site is refused). On an address that
others can reach the token decides.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
import socket
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

from starlette.datastructures import URL, Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

COOKIE = "dampyr_token"
MAX_BODY = 2**20  # bytes: far above the largest request, a campaign's text of 64 KiB
MAX_UPLOAD = 64 * 2**20  # bytes: many times a record of the published campaign
UPLOAD = "application/octet-stream"
ALLOWED = 5  # wrong tokens: a person mistypes a few times
PAUSE = 10.0  # s: six tokens a minute find none of 32 letters
MAX_ADDRESSES = 10_000  # that are remembered: 1 MB
HEADERS = {
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
}


def is_loopback(host: str) -> bool:
    """Whether an address or name reaches this machine alone."""
    return host == "localhost" or ((address := _address(host)) is not None and address.is_loopback)


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(host.strip("[]"))
    except ValueError:
        return None


@lru_cache(maxsize=1)
def own_names() -> frozenset[str]:
    """The names that this machine knows itself by."""
    return frozenset({socket.gethostname().lower(), socket.getfqdn().lower()})


@dataclass(eq=False)
class AnswerHeaders:
    """What a page may load, and what a browser may keep, on every answer; it lies outside of what makes any."""

    app: ASGIApp

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(raw=message.setdefault("headers", []))
                cache = "no-store" if scope["path"].startswith("/api") else "no-cache"
                for name, value in {**HEADERS, "cache-control": cache}.items():
                    headers.setdefault(name, value)
            await send(message)

        await self.app(scope, receive, sending)


@dataclass(eq=False)
class Check:
    """A layer that answers some requests itself and hands on the others; a WebSocket that it would answer is closed."""

    app: ASGIApp

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        answer = None if scope["type"] == "lifespan" else self.answer(HTTPConnection(scope))
        if answer is None:
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            await WebSocketClose(4403, "not allowed")(scope, receive, send)
        else:
            await answer(scope, receive, send)

    def answer(self, connection: HTTPConnection) -> Response | None:
        """The answer to what does not get further; None for the rest."""
        raise NotImplementedError


@dataclass(eq=False)
class TokenBrake(Check):
    """Wrong tokens by the address that they came from: after `ALLOWED` different ones each next one is `PAUSE` s away.

    One that is sent again counts once: a page that was left open has the token of the console before. The paths ``open_here``
    are not braked.
    """

    token: str
    open_here: frozenset[str]
    clock: Callable[[], float] = time.monotonic
    _wrong: OrderedDict[str, tuple[tuple[int, ...], float]] = field(default_factory=OrderedDict)

    def answer(self, connection: HTTPConnection) -> Response | None:
        presented = _presented(connection)
        if not presented or connection["path"] in self.open_here:
            return None
        address = connection.client.host if connection.client else ""
        hashes, last = self._wrong.get(address, ((), 0.0))
        seconds = last + PAUSE - self.clock()
        if len(hashes) >= ALLOWED and seconds > 0.0:
            words = f"too many wrong tokens came from this address; wait {seconds:.0f} s, and try again"
            return JSONResponse({"detail": words}, 429, {"retry-after": f"{seconds:.0f}"})
        if _same(presented, self.token):
            self._wrong.pop(address, None)
        elif hash(presented) not in hashes:
            self._wrong[address] = (*hashes, hash(presented))[-ALLOWED:], self.clock()
            self._wrong.move_to_end(address)
            if len(self._wrong) > MAX_ADDRESSES:
                self._wrong.popitem(last=False)
        return None


@dataclass(eq=False)
class HostCheck(Check):
    """Refuses names that are not this machine's; with ``loopback_only`` those that others can reach it by, too."""

    loopback_only: bool

    def answer(self, connection: HTTPConnection) -> Response | None:
        name = _name(connection.headers.get("host", ""))
        if is_loopback(name) or (not self.loopback_only and (_address(name) or name in own_names())):
            return None
        return _refusal(400, "this console does not have that name; open it at the address that it printed")


class OriginCheck(Check):
    """Refuses what another site sends, by its Origin or by what the browser says of it; a link may open the page."""

    def answer(self, connection: HTTPConnection) -> Response | None:
        headers = connection.headers
        if origins := headers.getlist("origin"):
            own = {f"http://{headers.get('host')}", f"https://{headers.get('host')}"}.issuperset(origins)
        else:
            opened = headers.get("sec-fetch-mode") == "navigate" and connection.scope.get("method") == "GET"
            link = opened and connection["path"] == "/"
            own = link or headers.get("sec-fetch-site", "none") in ("none", "same-origin")
        if own:
            return None
        return _refusal(403, "the request comes from another site; open the console at the address that it printed")


@dataclass(eq=False)
class TokenCheck(Check):
    """Asks for the token, but not for the page, which holds nothing, nor on this machine itself for the paths ``open_here``.

    The right one in ``/?token=...`` goes into a cookie, and out of the address.
    """

    token: str
    open_here: frozenset[str]

    def answer(self, connection: HTTPConnection) -> Response | None:
        path, client = connection["path"], connection.client
        right = _same(_presented(connection), self.token)
        if _is_page(connection):
            if not right or connection["method"] != "GET":
                return None
            entered = RedirectResponse("/", 303)
            entered.set_cookie(COOKIE, self.token, httponly=True, samesite="strict")
            return entered
        if right or (path in self.open_here and client and is_loopback(client.host)):
            return None
        return _refusal(401, "this console asks for its token; open it at the address that it printed")


@dataclass(eq=False)
class BodyLimit:
    """The application behind a limit on the body, whether its length is announced or not.

    Where it is not, the connection ends with the answer: nobody reads on what may have no end.
    """

    app: ASGIApp

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers, seen = Headers(raw=list(scope.get("headers", []))), 0
        is_whole = "transfer-encoding" not in headers
        limit = MAX_UPLOAD if headers.get("content-type") == UPLOAD else MAX_BODY
        words = f"too large; at most {limit // 2**20} MiB are taken"

        async def counted() -> Message:
            nonlocal seen, is_whole
            message = await receive()
            is_whole = is_whole or not message.get("more_body", False)
            seen += len(message.get("body", b""))
            if seen > limit:
                raise HTTPException(413, words)
            return message

        async def answered(message: Message) -> None:
            if message["type"] == "http.response.start" and not is_whole:
                message["headers"] = [*message.get("headers", ()), (b"connection", b"close")]
            await send(message)

        announced = headers.get("content-length", "0")
        if scope["type"] == "http" and not (re.fullmatch("[0-9]{1,20}", announced) and int(announced) <= limit):
            await _refusal(413, words)(scope, receive, send)
        else:
            await self.app(scope, counted, answered)


def _refusal(status: int, words: str) -> Response:
    return JSONResponse({"detail": words}, status)


def _same(presented: str, token: str) -> bool:
    """Whether two tokens are the same, in a time that does not tell how much of them is."""
    return hmac.compare_digest(presented.encode(), token.encode())


def _is_page(connection: HTTPConnection) -> bool:
    return connection["type"] == "http" and not connection["path"].startswith("/api")


def _presented(connection: HTTPConnection) -> str:
    """The token that a request brings, wherever it stands; "" where it brings none."""
    if _is_page(connection):
        return connection.query_params.get("token", "") if connection["path"] == "/" else ""
    bearer = connection.headers.get("authorization", "").removeprefix("Bearer ")
    return bearer or connection.cookies.get(COOKIE, "")


def _name(host: str) -> str:
    """The name or address of a Host header; "" where it holds anything else than that and a port."""
    try:
        url = URL(f"//{host}")
        return (url.hostname or "") if url.netloc == host and url.username is None and url.port != 0 else ""
    except ValueError:
        return ""
