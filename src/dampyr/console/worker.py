"""One job in a process of its own: ``python -m dampyr.console.worker FOLDER``.

It reports progress on its standard output, a line of JSON at a time, and ends when its standard input is closed: a job never
outlives the console that started it.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

from dampyr import registry
from dampyr.atomic_write import write_whole
from dampyr.console.job_processes import WORK
from dampyr.errors import DampyrError, DampyrWarning
from dampyr.to_json import plain

EVERY = 0.1  # s between two lines
YIELDS = 10  # of niceness: the console may be reading a moving rig at the same time


class ProgressReport:
    """``progress(stage, fraction done)``, reported at most every tenth of a second."""

    def __init__(self) -> None:
        self.stage, self.last = "", 0.0

    def __call__(self, stage: str, done: float) -> None:
        now = time.monotonic()
        if stage != self.stage or now - self.last >= EVERY or done >= 1.0:
            self.stage, self.last = stage, now
            say(stage=stage, progress=float(done))


def say(**fields: Any) -> None:
    """A line of JSON to the console."""
    print(json.dumps(fields), flush=True)


def end_with_the_console() -> None:
    """End this process and what it started when standard input is closed."""

    def wait() -> None:
        while os.read(0, 1024):  # not sys.stdin: its lock would be held when this process ends
            pass
        if os.name == "posix":
            os.killpg(os.getpgid(0), signal.SIGKILL)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def run(folder: Path) -> int:
    """Do the work that ``request.json`` in ``folder`` asks for; 0 when ``result.json`` is there."""
    request = json.loads((folder / "request.json").read_text("utf-8"))
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", DampyrWarning)
            result = registry.member(WORK, request["kind"]).run(request["request"], folder, ProgressReport())
    except DampyrError as problem:
        say(reason=str(problem))
        return 2
    except MemoryError:
        say(reason="it exceeded its memory limit; request less at once")
        return 2
    except Exception:
        traceback.print_exc()
        return 1
    messages = dict.fromkeys(str(warning.message) for warning in caught if issubclass(warning.category, DampyrWarning))
    write_whole(folder / "result.json", json.dumps(plain(result | {"warnings": list(messages)})))
    return 0


if __name__ == "__main__":
    end_with_the_console()
    if os.name == "posix":
        os.nice(YIELDS)
    sys.exit(run(Path(sys.argv[1])))
