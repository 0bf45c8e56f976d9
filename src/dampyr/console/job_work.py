"""Work of one job, in a process of its own: it reports progress to the console, and ends when the console does."""

from __future__ import annotations

import json
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

from dampyr import registry
from dampyr.atomic_write import write_whole
from dampyr.console.limits import yield_to_rig
from dampyr.errors import DampyrError, DampyrWarning
from dampyr.processes import end_with
from dampyr.to_json import plain

WORK = "dampyr.console.jobs"
EVERY = 0.1  # s between two reports


class ProgressReport:
    """``progress(stage, fraction done)``, sent at most every tenth of a second."""

    def __init__(self, send: Callable[[dict[str, object]], None]) -> None:
        self.send, self.stage, self.last = send, "", 0.0

    def __call__(self, stage: str, done: float) -> None:
        now = time.monotonic()
        if stage != self.stage or now - self.last >= EVERY or done >= 1.0:
            self.stage, self.last = stage, now
            self.send({"stage": stage[:80], "progress": min(1.0, max(0.0, float(done)))})


def do_job(connection: Connection, folder: Path) -> None:
    """Do the job of ``folder``; the exit status is 0 when ``result.json`` is there."""
    end_with(connection)
    yield_to_rig()
    sys.exit(run(folder, connection.send))


def run(folder: Path, send: Callable[[dict[str, object]], None]) -> int:
    """Do the work that ``request.json`` in ``folder`` asks for; 0 when ``result.json`` is there.

    ``send`` takes the ``stage`` and the ``progress``, and the ``reason`` for which there is no result.
    """
    request = json.loads((folder / "request.json").read_text("utf-8"))
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", DampyrWarning)
            result = registry.member(WORK, request["kind"]).run(request["request"], folder, ProgressReport(send))
    except DampyrError as problem:
        send({"reason": str(problem)})
        return 2
    except MemoryError:
        send({"reason": "it exceeded its memory limit; request less at once"})
        return 2
    except Exception:
        traceback.print_exc()
        return 1
    messages = dict.fromkeys(str(warning.message) for warning in caught if issubclass(warning.category, DampyrWarning))
    write_whole(folder / "result.json", json.dumps(plain(result | {"warnings": list(messages)})))
    return 0
