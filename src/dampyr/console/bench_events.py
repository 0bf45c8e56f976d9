"""Events of a bench, who did what and when: shown on its page, appended to a file, and kept with the records of a run."""

from __future__ import annotations

import json
import threading
from collections import deque
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path

FILE = "bench-events.jsonl"
SHOWN = 200  # events that a page shows
TAIL = 256 * 1024  # bytes of an earlier file that are read for them


@dataclass(frozen=True)
class BenchEvent:
    """``time`` with its zone, ``who`` did it (an operator and the page, an address, or the rig), and ``what`` in words."""

    time: str
    who: str
    what: str


class EventLog:
    """Events, the last ones in memory, all of them in a file of one JSON object a line."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        self.count = 0
        """How many were added."""
        self.trouble = ""
        """Why the last event could not be written; empty where it was."""
        self.run_folder: Path | None = None
        """The folder of the campaign under way, which gets the events too."""
        self._lock = threading.Lock()
        self._events: deque[BenchEvent] = deque(_earlier(self.path), maxlen=SHOWN)

    def add(self, who: str, what: str) -> None:
        """Note an event."""
        event = BenchEvent(datetime.now().astimezone().isoformat(timespec="milliseconds"), who, what)
        line = json.dumps(asdict(event)) + "\n"
        with self._lock:
            self._events.append(event)
            self.count += 1
            self.trouble = ""
            run = self.run_folder
            for path in (self.path, *([run / FILE] if run is not None else [])):
                try:
                    path.parent.mkdir(parents=True, exist_ok=True)
                    with path.open("a", encoding="utf-8") as file:
                        file.write(line)
                except OSError as problem:
                    self.trouble = f"{path.name} cannot be written ({problem.strerror}); make room"

    def recent(self) -> list[BenchEvent]:
        """The last events, the latest first."""
        with self._lock:
            return [*reversed(self._events)]


def _earlier(path: Path) -> list[BenchEvent]:
    """The last events of earlier sessions; a line that a kill has cut short is left out."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - TAIL))
            lines = file.read().decode("utf-8", errors="replace").splitlines()
    except OSError:
        return []
    events = []
    for line in lines:
        try:
            event = BenchEvent(**json.loads(line))
        except (ValueError, TypeError):
            continue
        events.append(event)
    return events[-SHOWN:]
