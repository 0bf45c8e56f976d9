"""Notes on records, saved in the console's own folder: the records themselves are never changed."""

from __future__ import annotations

import json
import threading
from pathlib import Path

from dampyr.atomic_write import write_whole
from dampyr.console.safe_paths import OWN
from dampyr.errors import InputError

ALONE = threading.Lock()
"""Held from reading to writing: of notes that are written at the same time none is lost."""
MAX_LENGTH = 2000  # characters, a page of text
MAX_NOTES = 5000  # all of them are read and written as one file


def notes(data: Path) -> dict[str, str]:
    """Key of a record -> what was written."""
    path = _path(data)
    saved: dict[str, str] = json.loads(path.read_text("utf-8")) if path.is_file() else {}
    return saved


def write_note(data: Path, key: str, text: str) -> None:
    """Keep a note; an empty one takes it away."""
    with ALONE:
        saved = notes(data)
        saved[key] = text.strip()[:MAX_LENGTH]
        if not saved[key]:
            del saved[key]
        if len(saved) > MAX_NOTES:
            raise InputError(f"there are {MAX_NOTES} notes already; take some away first")
        write_whole(_path(data), json.dumps(saved, ensure_ascii=False, indent=1))


def move_note(data: Path, key: str, to: str) -> None:
    """Give a note to another key, where a record has been renamed."""
    with ALONE:
        saved = notes(data)
        if key in saved:
            saved[to] = saved.pop(key)
            write_whole(_path(data), json.dumps(saved, ensure_ascii=False, indent=1))


def _path(data: Path) -> Path:
    return data / OWN / "notes.json"
