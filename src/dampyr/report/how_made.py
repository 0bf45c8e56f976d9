"""What a page was made with: the moment, the command, and the data files with their checksums.

A page that is printed and put away has to say how it can be made again. The command line and the console state their request
with `made_by`; in a script of one's own the call of the writer stands in its place.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from dampyr.source_file import SourceFile, source_file

if TYPE_CHECKING:
    from dampyr.models import Damper
    from dampyr.records import Record

FEW = 6  # names of operators, specimens or sessions that a page lists one by one


@dataclass(frozen=True)
class HowMade:
    """The command that makes a page, as one types it, and the files that it reads besides records."""

    command: str
    files: tuple[SourceFile, ...] = ()


_how_made: ContextVar[HowMade | None] = ContextVar("how pages are made", default=None)


@contextmanager
def made_by(command: str, files: Iterable[str | Path] = ()) -> Iterator[None]:
    """Within it, pages say that ``command`` made them, from ``files`` besides their records; what is no file is left out."""
    there = tuple(source_file(path) for path in map(Path, files) if path.is_file())
    before = _how_made.set(HowMade(command, there))
    try:
        yield
    finally:
        _how_made.reset(before)


def how_made(call: str = "") -> HowMade:
    """That of `made_by`, or outside it the script that runs and ``call``, the call of a writer in it."""
    given = _how_made.get()
    if given is not None:
        return given
    script = sys.argv[0] if sys.argv else ""
    words = [f"python {shlex.join(sys.argv)}"] if script and Path(script).is_file() else []
    return HowMade(": ".join([*words, call] if call else words) or "Python")


def moment() -> str:
    """Now, ISO 8601 with the zone of this machine, to the second; where SOURCE_DATE_EPOCH is set, that moment in UTC."""
    fixed = os.environ.get("SOURCE_DATE_EPOCH", "")
    at = datetime.fromtimestamp(int(fixed), UTC) if fixed.isdigit() else datetime.now().astimezone()
    return at.isoformat(timespec="seconds")


def files_of(records: Iterable[Record]) -> list[SourceFile]:
    """The files that records were read from, each once."""
    return list(dict.fromkeys(record.source_file for record in records if record.source_file is not None))


def people_and_parts(records: Iterable[Record]) -> Mapping[str, str]:
    """Operator, specimen and session of records, those that are stated."""
    records = list(records)
    stated = {
        "operator": [record.provenance.get("operator", "") for record in records],
        "specimen": [record.specimen or "" for record in records],
        "session": [record.measurement_session or "" for record in records],
    }
    listed = {name: sorted({each for each in values if each}) for name, values in stated.items()}
    return {name: _listing(values) for name, values in listed.items() if values}


def of_card(damper: Damper) -> dict[str, str]:
    """What the card says of its fit; its version of dampyr is not that of the page."""
    return {
        ("version" if k == "dampyr" else k): f"dampyr {v}" if k == "dampyr" else v for k, v in damper.provenance.items()
    }


def _listing(names: list[str]) -> str:
    return ", ".join(names[:FEW]) + (f" and {len(names) - FEW} more" if len(names) > FEW else "")
