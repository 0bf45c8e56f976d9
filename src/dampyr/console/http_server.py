"""Serve the console until it is stopped."""

from __future__ import annotations

import logging
import secrets
import socket
import webbrowser
from collections.abc import Callable
from pathlib import Path
from threading import Timer
from typing import Any

from dampyr.console.request_process import FORKED
from dampyr.console.rigs import Opener, opened
from dampyr.console.security import is_loopback
from dampyr.errors import InputError
from dampyr.processes import begin_to_import

PORT = 8077  # any free port above 1023 would do


def serve(
    data: str | Path,
    host: str = "127.0.0.1",
    port: int = PORT,
    token: str | None = None,
    browser: bool = True,
    quota: int | None = None,
    tell: Callable[[str], None] = print,
    opener: Opener = opened,
) -> None:
    """Serve the console over the folder ``data`` until it is interrupted.

    Parameters
    ----------
    data
        The folder of records, cards and campaigns, and where everything is written.
    host
        The address to listen on; by default only this machine reaches it.
    port
        The port to listen on; 0 takes a free one.
    token
        What a browser must present. On an address that others can reach one is made, and told once, where none is given.
    browser
        Whether the address is opened in a browser.
    quota
        Bytes that the data folder may hold before uploads are refused; by default 4 GiB.
    tell
        Called with the address to open.
    opener
        ``opener(data, name, simulate)`` connects the bench's rig, for rigs that a ``rig.toml`` cannot describe.

    Raises
    ------
    InputError
        Where the address cannot be had, or the token is shorter than 8 letters.
    """
    import uvicorn

    from dampyr.console.application import QUOTA, app

    local = is_loopback(host)
    token = token if token is not None or local else secrets.token_urlsafe(24)
    if token is not None and len(token) < 8:
        raise InputError(f"a token of {len(token)} letters is too short; give at least 8")
    listening = _listening(host, port)
    begin_to_import(FORKED)
    application = app(data, token, local, quota or QUOTA, opener=opener)
    shown_host = socket.gethostname() if host in ("0.0.0.0", "::") else f"[{host}]" if ":" in host else host
    address = f"http://{shown_host}:{listening.getsockname()[1]}/" + (f"?token={token}" if token else "")
    tell(address)
    if browser:
        Timer(0.5, webbrowser.open, (address,)).start()
    logging.basicConfig(level=logging.WARNING)
    settings: dict[str, Any] = {
        "log_level": "warning",
        "access_log": False,
        "server_header": False,
        "ws_max_size": 2**20,
    }

    class Server(uvicorn.Server):
        """Ends in order however often it is told to: the rig is disarmed, and a second Ctrl+C cannot cut that short."""

        def handle_exit(self, sig: int, frame: Any) -> None:
            if not self.should_exit:
                super().handle_exit(sig, frame)

    Server(uvicorn.Config(application, timeout_graceful_shutdown=3, **settings)).run(sockets=[listening])


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        listener.listen(128)  # before the address is told
    except (OSError, OverflowError) as problem:
        listener.close()
        raise InputError(f"{host}, port {port} cannot be had ({problem}); choose another --port or --host") from None
    return listener
