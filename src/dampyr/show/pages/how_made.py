"""What a page was made with: the moment, the command, and the data files with their checksums.

A page that is printed and put away has to say how it can be made again. The command line and the console state their request
with `made_by`; in a script of one's own the call of the writer stands in its place.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from dampyr.source_file import SourceFile, source_file


@dataclass(frozen=True)
class HowMade:
    """The command that makes a page, as one types it, and the files that it reads besides records."""

    command: str
    files: tuple[SourceFile, ...] = ()


_how_made: ContextVar[HowMade | None] = ContextVar("how pages are made", default=None)


@contextmanager
def made_by(command: str, files: Iterable[str | Path] = ()) -> Iterator[None]:
    """Within it, pages say that ``command`` made them, from ``files`` besides their records; what is not a file is left out."""
    sources = tuple(source_file(path) for path in map(Path, files) if path.is_file())
    before = _how_made.set(HowMade(command, sources))
    try:
        yield
    finally:
        _how_made.reset(before)


def how_made(call: str = "") -> HowMade:
    """That of `made_by`, or outside it the script that runs and ``call``, the call of a writer in it."""
    stated = _how_made.get()
    if stated is not None:
        return stated
    script = sys.argv[0] if sys.argv else ""
    words = [f"python {shlex.join(sys.argv)}"] if script and Path(script).is_file() else []
    return HowMade(": ".join([*words, call] if call else words) or "Python")


def moment() -> str:
    """Now, ISO 8601 with the zone of this machine, to the second; where SOURCE_DATE_EPOCH is set, that moment in UTC."""
    fixed = os.environ.get("SOURCE_DATE_EPOCH", "")
    at = datetime.fromtimestamp(int(fixed), UTC) if fixed.isdigit() else datetime.now().astimezone()
    return at.isoformat(timespec="seconds")
