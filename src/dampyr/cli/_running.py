"""A campaign while it runs, in a terminal: bars, live numbers and keys."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from typing import Any

from dampyr.campaigns import Plan, RunControl
from dampyr.campaigns.run_control import Progress

LOOKS = 0.1  # s between two looks at the bars
Show = Callable[[Progress], None]


@contextmanager
def shown(plan: Plan) -> Iterator[Show]:
    """A function that shows progress: bars where somebody looks, a line per test where nobody does.

    Where stderr cannot be written any more, as when its reader has left, nothing is shown from then on: that ends no test.
    """
    with _bars(plan) if sys.stderr.isatty() else nullcontext(_lines()) as show:
        yield _while_written(show)


def _while_written(show: Show) -> Show:
    failed = False

    def show_if_possible(progress: Progress) -> None:
        nonlocal failed
        if not failed:
            try:
                show(progress)
            except (OSError, ValueError):  # ValueError: the stream was closed
                failed = True

    return show_if_possible


@contextmanager
def _bars(plan: Plan) -> Iterator[Show]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
    from rich.progress import Progress as Bars

    class Quiet(Console):
        def on_broken_pipe(self) -> None:
            """Show nothing more; rich would end the process."""
            self.quiet = True

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[message]}"),
    )
    # refreshed by the calls: in a thread of its own an error would go nowhere
    bars = Bars(*columns, console=Quiet(stderr=True), auto_refresh=False)
    whole = bars.add_task(plan.campaign.header.name, total=len(plan.tests), message="")
    test = bars.add_task("", total=100, message="")
    last = 0.0

    def show(progress: Progress) -> None:
        nonlocal last
        if progress.samples is not None and time.monotonic() - last < LOOKS:
            return
        last = time.monotonic()
        bars.update(whole, completed=progress.done, message=f"{_clock(progress.time_left)} of rig time left")
        name = f"{progress.phase} {progress.name}".strip()
        bars.update(test, description=name, completed=round(100 * progress.fraction), message=_live(progress))
        bars.refresh()

    with suppress(OSError, ValueError):
        bars.start()
    try:
        yield show
    finally:
        with suppress(OSError, ValueError):
            bars.stop()


def _live(progress: Progress) -> str:
    if progress.samples is None:
        return ""
    return (
        f"cycle {progress.cycles:.0f} of {progress.planned_cycles:.0f}, {progress.force:+7.1f} N, "
        f"{progress.stroke * 1e3:5.2f} mm, {progress.temperature:.1f} degC"
    )


def _clock(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


def _lines() -> Show:
    last, start = "", time.monotonic()

    def show(progress: Progress) -> None:
        nonlocal last
        now = f"{progress.phase} {progress.name}".strip()
        if now != last and progress.phase != "rest":
            where = f"{progress.done + 1}/{progress.total}" if progress.name else "-"
            left = _clock(progress.time_left)
            line = f"{time.monotonic() - start:6.1f} s  {where}  {now}  ({left} of rig time left)"
            print(line, file=sys.stderr, flush=True)
            last = now

    return show


@contextmanager
def stopped_by_signals() -> Iterator[None]:
    """A request to end the process, or a terminal that is closed, ends the campaign in order, as Ctrl-C does.

    A signal that is ignored, as by nohup, stays so.
    """

    def leave(number: int, _: Any) -> None:
        raise SystemExit(128 + number)

    numbers = [signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]
    before = {number: signal.signal(number, leave) for number in numbers if signal.getsignal(number) != signal.SIG_IGN}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def keys(control: RunControl) -> Iterator[None]:
    """Listen to p, s and a, where there is a terminal to type at."""
    if not sys.stdin.isatty():
        yield
        return
    over = threading.Event()
    with _unbuffered() as read:
        listener = threading.Thread(target=_listen, args=(read, control, over), daemon=True)
        listener.start()
        try:
            yield
        finally:
            over.set()
            listener.join(1.0)


def _listen(read: Callable[[], str], control: RunControl, over: threading.Event) -> None:
    while not over.is_set():
        key = read().lower()
        if key == "p":
            control.resume() if control.paused else control.pause()
        elif key == "s":
            control.stop()
        elif key == "a":
            control.abort()


@contextmanager
def _unbuffered() -> Iterator[Callable[[], str]]:
    """A function that gives the next key, or nothing after a moment."""
    with suppress(ImportError):
        import select
        import termios
        import tty

        saved_attributes = termios.tcgetattr(sys.stdin)
        tty.setcbreak(sys.stdin)
        try:
            yield lambda: sys.stdin.read(1) if select.select([sys.stdin], [], [], 0.1)[0] else ""
        finally:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, saved_attributes)
        return
    import msvcrt  # the same on Windows

    def read() -> str:
        time.sleep(0.05)
        return str(msvcrt.getwch()) if msvcrt.kbhit() else ""  # type: ignore[attr-defined]

    yield read
