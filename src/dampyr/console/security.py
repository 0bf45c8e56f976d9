"""Access control: Host, Origin and token of every request and WebSocket, the size of requests, and what a page may load.

A page of another site can make a browser send requests here. It cannot choose their Host (so a foreign name that resolves to
this machine is refused), nor hide their Origin (so a request or a WebSocket from another site is refused). On an address that
others can reach the token decides.
"""

from __future__ import annotations

import hmac
import ipaddress
import socket
import time
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from dataclasses import dataclass, field
from functools import lru_cache
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

from starlette.responses import JSONResponse, RedirectResponse, Response

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]

COOKIE = "dampyr_token"
MAX_BODY = 2**20  # bytes: far above the largest request, a campaign's text of 64 KiB
MAX_UPLOAD = 64 * 2**20  # bytes: many times a record of the published campaign
UPLOAD = "application/octet-stream"
ALLOWED = 5  # wrong tokens: a person mistypes a few times
PAUSE = 10.0  # s: six tokens a minute find none of 32 letters
MAX_ADDRESSES = 10_000  # that are remembered: 1 MB
SAFE = ("GET", "HEAD", "OPTIONS")
POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
}


def is_loopback(host: str) -> bool:
    """Whether an address or name reaches this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


@lru_cache(maxsize=1)
def own_names() -> frozenset[str]:
    """The names that this machine knows itself by."""
    return frozenset({socket.gethostname().lower(), socket.getfqdn().lower()})


@dataclass(frozen=True)
class Rules:
    """Who may ask. ``open_here`` are paths that need no token from this machine itself: the abort of the bench."""

    token: str | None
    loopback_only: bool = True
    open_here: frozenset[str] = frozenset()

    def refusal(self, scope: Scope) -> tuple[int, str] | None:
        """Status and sentence for what is not allowed, or None."""
        headers = _headers(scope)
        if not self._allows_host(headers.get("host", "")):
            return 400, "this console does not have that name; open it at the address that it printed"
        if _foreign(scope, headers):
            return 403, "the request comes from another site; open the console at the address that it printed"
        if self.token is not None and not self._has_token(scope, headers):
            return 401, "this console asks for its token; open it at the address that it printed"
        return None

    def _allows_host(self, host: str) -> bool:
        name = (urlsplit(f"//{host}").hostname or "") if _splits(host) else ""
        if is_loopback(name):
            return True
        if self.loopback_only:
            return False
        return _is_address(name) or name in own_names()

    def _has_token(self, scope: Scope, headers: dict[str, str]) -> bool:
        assert self.token is not None
        if scope["type"] == "http" and not scope["path"].startswith("/api"):
            return True  # the page itself holds nothing; it asks for the token
        client = scope.get("client")
        if scope["path"] in self.open_here and client and is_loopback(client[0]):
            return True
        presented = headers.get("authorization", "").removeprefix("Bearer ") or _cookie(headers.get("cookie", ""))
        return same(presented, self.token)


def same(presented: str, token: str) -> bool:
    """Whether two tokens are the same, in a time that does not tell how much of them is."""
    return hmac.compare_digest(presented.encode(), token.encode())


@dataclass
class Brake:
    """Wrong tokens by the address that they came from: after `ALLOWED` different ones each next one is `PAUSE` s away.

    One that is sent again counts once: a page that was left open has the token of the console before.
    """

    clock: Callable[[], float]
    _wrong: OrderedDict[str, tuple[tuple[int, ...], float]] = field(default_factory=OrderedDict)

    def wait(self, address: str) -> float:
        """s until a token from ``address`` is looked at."""
        wrong, last = self._wrong.get(address, ((), 0.0))
        return max(0.0, last + PAUSE - self.clock()) if len(wrong) >= ALLOWED else 0.0

    def count(self, address: str, presented: str, right: bool) -> None:
        """A token was looked at."""
        wrong, last = self._wrong.pop(address, ((), 0.0))
        if not right:
            new = hash(presented) not in wrong
            latest = (*wrong, hash(presented))[-ALLOWED:] if new else wrong
            self._wrong[address] = (latest, self.clock() if new else last)
        while len(self._wrong) > MAX_ADDRESSES:
            self._wrong.popitem(last=False)


class Guard:
    """The outermost layer of the console: `Rules` before everything, headers on everything, bodies counted."""

    def __init__(self, inner: Any, rules: Rules, clock: Callable[[], float] = time.monotonic) -> None:
        self.inner, self.rules, self.brake = inner, rules, Brake(clock)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.inner(scope, receive, send)
        elif (refused := self._answer(scope)) is not None:
            await _refuse(scope, receive, send, refused)
        elif scope["type"] == "http":
            await self._counted(scope, receive, send)
        else:
            await self.inner(scope, receive, send)

    def _answer(self, scope: Scope) -> Response | None:
        """The answer to what does not reach the application: a refusal, or the address with a token in it."""
        if (braked := self._braked(scope)) is not None:
            return braked
        entered = self._entered(scope)
        if entered is not None:
            return entered
        refusal = self.rules.refusal(scope)
        return None if refusal is None else JSONResponse({"detail": refusal[1]}, refusal[0])

    def _braked(self, scope: Scope) -> Response | None:
        """The answer to an address that has sent wrong tokens again and again: none of its tokens is looked at for a while."""
        token, presented = self.rules.token, _presented(scope)
        address = (scope.get("client") or ("",))[0]
        if token is None or not presented or scope["path"] in self.rules.open_here:
            return None
        if (seconds := self.brake.wait(address)) > 0.0:
            words = f"too many wrong tokens came from this address; wait {seconds:.0f} s, and try again"
            return JSONResponse({"detail": words}, 429, {"retry-after": f"{seconds:.0f}"})
        self.brake.count(address, presented, same(presented, token))
        return None

    def _entered(self, scope: Scope) -> Response | None:
        """``/?token=...`` with the right token: keep it in a cookie, and take it out of the address."""
        token = self.rules.token
        if token is None or scope["type"] != "http" or scope["path"] != "/" or scope["method"] != "GET":
            return None
        bare = Rules(None, self.rules.loopback_only)
        if not same(_presented(scope), token) or bare.refusal(scope) is not None:
            return None
        answer = RedirectResponse("/", 303)
        answer.set_cookie(COOKIE, token, httponly=True, samesite="strict")
        return answer

    async def _counted(self, scope: Scope, receive: Receive, send: Send) -> None:
        """The application behind a limit on the body, whether its length is announced or not."""
        headers = _headers(scope)
        limit = MAX_UPLOAD if headers.get("content-type") == UPLOAD else MAX_BODY
        announced = headers.get("content-length", "0")
        if not announced.isdigit() or int(announced) > limit:
            await _too_large(limit)(scope, receive, _with_headers(send, scope))
            return
        seen, answered = 0, False

        async def limited() -> Message:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b""))
            if seen > limit:
                raise _TooLarge
            return message

        async def noting(message: Message) -> None:
            nonlocal answered
            answered = True
            await _with_headers(send, scope)(message)

        try:
            await self.inner(scope, limited, noting)
        except _TooLarge:
            if not answered:
                await _too_large(limit)(scope, receive, _with_headers(send, scope))


class _TooLarge(BaseException):
    """Past the limit; no endpoint may catch it."""


def _too_large(limit: int) -> Response:
    return JSONResponse({"detail": f"too large; at most {limit // 2**20} MiB are taken"}, 413)


async def _refuse(scope: Scope, receive: Receive, send: Send, answer: Response) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 4403, "reason": "not allowed"})
        return
    await answer(scope, receive, _with_headers(send, scope))


def _with_headers(send: Send, scope: Scope) -> Send:
    added = HEADERS | {"cache-control": "no-store" if scope["path"].startswith("/api") else "no-cache"}

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            own = {name.lower() for name, _ in message.get("headers", [])}
            more = [(k.encode(), v.encode()) for k, v in added.items() if k.encode() not in own]
            message["headers"] = [*message.get("headers", []), *more]
        await send(message)

    return sending


def _headers(scope: Scope) -> dict[str, str]:
    pairs: Iterable[tuple[bytes, bytes]] = scope.get("headers", [])
    return {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in pairs}


def _foreign(scope: Scope, headers: dict[str, str]) -> bool:
    """Whether another site asks: by its Origin, or by what the browser says of it."""
    origin = headers.get("origin")
    if origin is not None:
        return origin not in (f"http://{headers.get('host')}", f"https://{headers.get('host')}")
    if headers.get("sec-fetch-site", "none") in ("none", "same-origin"):
        return False
    opened = headers.get("sec-fetch-mode") == "navigate" and scope.get("method") == "GET"
    return not (opened and scope["path"] == "/")


def _splits(host: str) -> bool:
    try:
        port = urlsplit(f"//{host}").port
    except ValueError:
        return False
    return (port is None or port > 0) and "@" not in host and "/" not in host


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _presented(scope: Scope) -> str:
    """The token that a request brings, wherever it stands; "" where it brings none."""
    if scope["path"] == "/":
        return parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
    if not scope["path"].startswith("/api"):
        return ""  # the page itself needs none
    headers = _headers(scope)
    return headers.get("authorization", "").removeprefix("Bearer ") or _cookie(headers.get("cookie", ""))


def _cookie(text: str) -> str:
    try:
        cookie = SimpleCookie(text).get(COOKIE)
    except CookieError:
        return ""
    return cookie.value if cookie else ""
