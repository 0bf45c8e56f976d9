"""Progress of long work, on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Show = Callable[[str, float], None]
QUIET = 5.0  # s between two lines about one stage in a log; with 4 s between two reports, less than ten


_followed: ContextVar[Show | None] = ContextVar("who is told of progress instead of stderr", default=None)


@contextmanager
def followed(show: Show) -> Iterator[None]:
    """Within it, ``show(stage, fraction done)`` is told of progress, and nothing of it goes to stderr."""
    before = _followed.set(show)
    try:
        yield
    finally:
        _followed.reset(before)


def is_followed() -> bool:
    """Whether this is within `followed`."""
    return _followed.get() is not None


@contextmanager
def stages() -> Iterator[Show]:
    """A function ``(stage, fraction done)`` that shows one bar per stage, or prints one line per stage into a log."""
    if (show := _followed.get()) is not None:
        yield show
        return
    if not sys.stderr.isatty():
        yield _lines()
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as bars:
        tasks: dict[str, int] = {}

        def draw(stage: str, done: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=1.0)
            bars.update(tasks[stage], completed=done)  # type: ignore[arg-type]

        yield draw


def _lines() -> Show:
    reported: set[str] = set()
    start = last = time.monotonic()

    def show(stage: str, done: float) -> None:
        nonlocal last
        now = time.monotonic()
        new = stage not in reported
        if new or (now - last >= QUIET and done < 1.0):
            reported.add(stage)
            last = now
            print(f"{now - start:6.1f} s  {stage}{'' if new else f', {done:.0%}'}", file=sys.stderr, flush=True)

    return show
