"""The process from which those that answer requests are forked: ``python -m dampyr.console.worker_template FD``.

It has imported what they need, so that a request waits some milliseconds for its process and not a second. For each request
it is handed one end of a socket; the process forked for it takes its limits, does what the first message says, writes what
comes of it as lines of JSON, and ends. It ends too when the other end of its socket is closed: the request was withdrawn.

With ``-`` in place of the descriptor it answers one request on its standard input and output, where a system cannot fork.
"""

from __future__ import annotations

import errno
import json
import os
import pickle
import signal
import socket
import struct
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, BinaryIO

from dampyr.errors import DampyrError, MissingData

PRELOADED = (
    "dampyr.console.campaign_plans",
    "dampyr.console.record_answers",
    "dampyr.console.record_acceptance",
    "dampyr.console.record_uploads",
    "dampyr.console.dampers",
)
YIELDS = 10  # of niceness: the console may be reading a moving rig at the same time
MAX_REASON = 600  # characters: a sentence for a person, whatever a file's header holds
MAX_ANSWER = 64 * 2**20  # bytes of one line: the lines of six records take a tenth


def answer(reading: BinaryIO, writing: BinaryIO) -> None:
    """Do what one request says and write what comes of it."""

    def say(**message: Any) -> None:
        line = json.dumps(message).encode()
        if len(line) > MAX_ANSWER:
            line = json.dumps(
                {"refused": f"the answer has more than {MAX_ANSWER // 2**20} MiB; request less at once"}
            ).encode()
        writing.write(line + b"\n")
        writing.flush()

    say(pid=os.getpid())
    (size,) = struct.unpack(">Q", reading.read(8))
    function, arguments, limits = pickle.loads(reading.read(size))
    if os.name == "posix":
        os.nice(YIELDS)
    limits.apply()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = function(*arguments)
            if isinstance(result, Iterator):
                for part in result:
                    say(part=part)
                result = None
            say(result=result)
    except DampyrError as problem:
        text = str(problem)
        sentence = text if len(text) <= MAX_REASON else f"{text[: MAX_REASON - 2]} …"
        say(refused=sentence, missing=isinstance(problem, MissingData))
    except (MemoryError, RecursionError):
        say(refused=limits.too_much)
    except Exception as problem:
        if isinstance(problem, OSError) and problem.errno in (errno.EFBIG, errno.EDQUOT):
            say(refused="it writes more than a request may; request less at once")
        else:
            traceback.print_exc()
            say(fault=True)


def end_with(link: socket.socket) -> None:
    """End this process when the other end of ``link`` is closed."""

    def wait() -> None:
        while link.recv(1):
            pass
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def serve(control: socket.socket) -> None:
    """Fork a process for each socket that is handed over, until ``control`` is closed."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for them here
    while True:
        message, descriptors, _, _ = socket.recv_fds(control, 1, 1)
        if not message:
            return
        if os.fork() == 0:
            control.close()
            _work(descriptors[0])
        os.close(descriptors[0])


def _work(descriptor: int) -> None:
    """The life of a forked process."""
    code = 1
    try:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        link = socket.socket(fileno=descriptor)
        writing = link.makefile("wb")
        answer(_Received(link), writing)  # type: ignore[arg-type]
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


class _Received:
    """The request as it comes; once it is here, a closed socket ends the process."""

    def __init__(self, link: socket.socket) -> None:
        self.link, self.count = link, 0

    def read(self, size: int) -> bytes:
        pieces = bytearray()
        while len(pieces) < size:
            piece = self.link.recv(size - len(pieces))
            if not piece:
                os._exit(1)
            pieces += piece
        self.count += 1
        if self.count == 2:  # its length, and itself
            end_with(self.link)
        return bytes(pieces)


def main(argument: str) -> None:
    """Serve, or answer once."""
    if argument == "-":
        writing = os.fdopen(os.dup(1), "wb")
        os.dup2(2, 1)  # what a library prints is not part of the answer
        answer(sys.stdin.buffer, writing)
        return
    control = socket.socket(fileno=int(argument))
    for name in PRELOADED:
        import_module(name)
    warm_up: Callable[[], None] = import_module(PRELOADED[0]).warm_up
    warm_up()
    serve(control)


if __name__ == "__main__":
    main(sys.argv[1])
