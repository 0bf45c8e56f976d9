"""Processes of dampyr's own: what it takes to start one, and to abort a rig that another process reads.

A rig's loop is asked over a link whose questions end after a time; a proxy of `multiprocessing.managers`, which waits for ever,
is what that has to stand beside.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.managers import BaseManager
from pathlib import Path
from typing import Any

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.errors import RigFault
from dampyr.processes import ChildProcess
from dampyr.rig import simulated
from dampyr.rig.loop_process import StandIn

TITLE = "A process that has imported what reads a rig, and a question to such a process"


class Thing:
    """What a proxy asks."""

    def origin(self) -> str:
        """A short answer, as that of a board."""
        return "simulated"


class Manager(BaseManager):
    """A process with a `Thing`."""


Manager.register("Thing", Thing)


def begin(connection: Any) -> None:
    """Say that it has begun; what this module needs has been imported then."""
    connection.send("begun")


def run(data: Path | None) -> list[Line]:
    """Starts of a process; questions of this thread and of a new one; an abort of a rig in motion."""
    command = [sys.executable, "-c", f"import {__name__}"]
    starts = {
        "start: a copy": _started(__name__),
        "start: anew": _started(""),
        "start: subprocess": lambda: subprocess.run(command, check=True),
    }
    with Manager(ctx=get_context("spawn")) as manager, simulated(real_time=True) as rig:
        proxy = manager.Thing()  # type: ignore[attr-defined]
        assert isinstance(rig.board, StandIn)
        questions = {
            "question: the rig's link": rig.board.origin,
            "question: manager": proxy.origin,
            "question of a new thread: the rig's link": _in_a_new_thread(rig.board.origin),
            "question of a new thread: manager": _in_a_new_thread(proxy.origin),
        }
        lines = [*race(starts, {}), *race(questions, {})]
        return [*lines, _aborts(rig)]


def _started(template: str) -> Callable[[], None]:
    def start() -> None:
        child = ChildProcess(begin, forked=template)
        child.connections[0].recv()
        child.end()

    return start


def _in_a_new_thread(call: Callable[[], object]) -> Callable[[], None]:
    def ask() -> None:
        thread = threading.Thread(target=call)
        thread.start()
        thread.join()

    return ask


def _aborts(rig: Any) -> Line:
    """How long an abort takes until the rig has cut its coil and braked."""
    times: list[float] = []
    for _ in range(10):
        try:
            with rig.armed() as table:
                table.home(here=True)
                table.jog(0.005, 0.5, wait=False)
                table.rest(0.1)
                start = time.perf_counter()
                table.abort()
                times.append(time.perf_counter() - start)
        except RigFault:  # it was aborted
            pass
    return Line("abort until the rig has braked", statistics.median(times), min(times), len(times), "")
