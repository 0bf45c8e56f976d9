"""Deferral of signals that would end the process, while a rig is brought to rest."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextmanager
def deferred_signals(discard: bool = False) -> Iterator[None]:
    """Ctrl-C and requests to end the process wait until the block is left; with ``discard`` they are then forgotten, because
    the process is ending already. Only the main thread is interrupted by signals: in others nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    waiting: list[int] = []
    heard = [number for number in ENDING if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, lambda arrived, _: waiting.append(arrived)) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
    if waiting and not discard:
        signal.raise_signal(waiting[0])
