"""Pseudo-terminals in the Uno's place, and errors that the page on the firmware has in its table."""

from __future__ import annotations

import os
import re
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[3] / "docs/how-to/firmware.md").read_text("utf-8")
TABLE = [line.split("|")[1].strip().replace("`", "") for line in PAGE.splitlines() if line.startswith("| ")]
posix = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals of POSIX")


def one_line(problem: object, *words: str) -> None:
    """It is one line, with these words, and the page on the firmware has it in its table."""
    text = str(problem).strip()
    assert "\n" not in text, text
    for each in words:
        assert re.search(each, text), text
    assert any(all(part.strip() in text for part in row.split("...")) for row in TABLE if len(row) > 15), text


@contextmanager
def terminal(answer: Callable[[bytes], bytes]) -> Iterator[str]:
    """A pseudo-terminal with a device at its end that is no Uno."""
    import pty
    import select
    import tty

    near, far = pty.openpty()
    tty.setraw(near)
    over = threading.Event()

    def run() -> None:
        while not over.is_set():
            data = os.read(near, 256) if select.select([near], [], [], 0.02)[0] else b""
            if reply := answer(data):
                os.write(near, reply)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield os.ttyname(far)
    finally:
        over.set()
        thread.join()
        os.close(near)
        os.close(far)
