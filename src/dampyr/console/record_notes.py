"""What people wrote about records, kept in the console's own folder: the records themselves are never changed."""

from __future__ import annotations

import json
from pathlib import Path

from dampyr.atomic_write import write_whole
from dampyr.console.safe_paths import OWN
from dampyr.errors import InputError

LONGEST = 2000
MOST = 5000


def notes(data: Path) -> dict[str, str]:
    """Key of a record -> what was written."""
    path = _path(data)
    found: dict[str, str] = json.loads(path.read_text("utf-8")) if path.is_file() else {}
    return found


def write_note(data: Path, key: str, text: str) -> None:
    """Keep a note; an empty one takes it away."""
    found = notes(data)
    found[key] = text.strip()[:LONGEST]
    if not found[key]:
        del found[key]
    if len(found) > MOST:
        raise InputError(f"there are {MOST} notes already; take some away first")
    write_whole(_path(data), json.dumps(found, ensure_ascii=False, indent=1))


def _path(data: Path) -> Path:
    return data / OWN / "notes.json"
