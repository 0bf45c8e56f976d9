"""The list of a source's records: what they are is read once, in a process with limits, and stored for as long as they stay."""

from __future__ import annotations

import threading
from collections import OrderedDict
from pathlib import Path
from typing import Any

from starlette.requests import Request

from dampyr.console import record_sources
from dampyr.console.error_responses import MAX_SENTENCE, without_places
from dampyr.console.limits import LISTING
from dampyr.console.page_words import in_page_words
from dampyr.console.record_answers import describe_all
from dampyr.console.workers import Workers
from dampyr.errors import DampyrError, InputError

MAX_STORED = 2000  # descriptions of some 4 kB


class RecordList:
    """Descriptions of records by their keys and the stamps of their files."""

    def __init__(self) -> None:
        self._stored: OrderedDict[tuple[Any, ...], dict[str, Any]] = OrderedDict()
        self._lock = threading.Lock()

    async def describe(
        self, workers: Workers, request: Request | None, data: Path, keys: list[str]
    ) -> dict[str, dict[str, Any]]:
        """Key -> ``about`` or ``problem``, of the files that are meant as records."""
        stamps = {key: stamp for key in keys if (stamp := _stamp(data, key)) is not None}
        with self._lock:
            described = {key: self._stored[stamp] for key, stamp in stamps.items() if stamp in self._stored}
        new = [key for key in stamps if key not in described]
        for key, answer in zip(
            new, await workers.each(request, LISTING, describe_all, new, data) if new else (), strict=True
        ):
            entry = {"problem": str(answer)} if isinstance(answer, InputError) else answer
            if "problem" in entry:
                entry = {"problem": in_page_words(without_places(entry["problem"], data))[:MAX_SENTENCE]}
            described[key] = entry
            with self._lock:
                self._stored[stamps[key]] = entry
                while len(self._stored) > MAX_STORED:
                    self._stored.popitem(last=False)
        return {key: described[key] for key in keys if described.get(key)}


def _stamp(data: Path, key: str) -> tuple[Any, ...] | None:
    try:
        return (key, *record_sources.stamp(data, key))
    except (DampyrError, OSError):
        return None  # gone since it was listed
