"""Notes of compiling: who wants to know is told when a kernel that no cache holds begins to be compiled, and when it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

Watcher = Callable[[bool], None]

_watchers: list[Watcher] = []


def note(begins: bool) -> None:
    """Tell the watchers of this process that a kernel begins to be compiled, or, ``begins`` false, that it is compiled."""
    for watcher in tuple(_watchers):
        watcher(begins)


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Call ``watcher(True)`` when a kernel begins to be compiled in this process and ``watcher(False)`` when it is compiled."""
    _watchers.append(watcher)
    try:
        yield
    finally:
        _watchers.remove(watcher)
