"""Log of what happens in a simulated rig: a line of JSON per event, written as it happens."""

from __future__ import annotations

import json
from pathlib import Path


class EventFile:
    """A file with a line of JSON per event; None: none is written."""

    def __init__(self, path: str | Path | None) -> None:
        self.path = None if path is None else Path(path)

    def __call__(self, when: float, event: str) -> None:
        if self.path is not None:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"time": round(when, 6), "event": event}) + "\n")
