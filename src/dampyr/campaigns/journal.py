"""What happened in a campaign's folder, in SQLite: the plan, the state of each test, and every event with its time.

Each entry is on the disk before the next thing happens, so that a killed campaign tells how far it came. The measurements
themselves are in the files of the tests, and where the two differ the files are right: a journal that is lost is made anew from
them (`dampyr.campaigns.recorded_tests`).
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from dampyr.errors import FileError, InputError
from dampyr.origin import NOT_STATED, Origin, as_origin
from dampyr.shown import Shown

NAME = "journal.sqlite"
SCHEMA = 1  # of the tables below; raised when they change
TestState = Literal["planned", "running", "complete", "stopped", "failed", "gone", "broken"]
"""Of a test; gone or broken: its journal says complete, and its file is not there or cannot be read."""
UNWRITABLE = (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM, sqlite3.SQLITE_AUTH)

TABLES = """
CREATE TABLE IF NOT EXISTS campaign (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS tests (
    name TEXT PRIMARY KEY, place INTEGER NOT NULL, state TEXT NOT NULL, attempt INTEGER NOT NULL, reason TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS events (
    id INTEGER PRIMARY KEY, time TEXT NOT NULL, test TEXT NOT NULL, attempt INTEGER NOT NULL, what TEXT NOT NULL,
    detail TEXT NOT NULL
);
"""


COLUMNS = (
    "tests.name",
    "place",
    "state",
    "tests.attempt",
    "reason",
    "id",
    "time",
    "test",
    "events.attempt",
    "what",
    "detail",
)
GOES_ON = "run the campaign again: it goes on"
REPAIR = "move it away, and the same command makes it anew from the records; or choose another folder"


@dataclass(frozen=True)
class JournalEntry:
    """A test in the journal."""

    name: str
    state: TestState
    attempt: int
    reason: str


@dataclass(frozen=True)
class Event:
    """Something that happened: when (UTC), to which try of which test, what, and the rest in words."""

    time: str
    test: str
    attempt: int
    what: str
    detail: str


def now(timespec: str = "milliseconds") -> str:
    """The time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec=timespec)


class Journal(Shown):
    """The journal of a folder; made where there is none."""

    def __init__(self, folder: str | Path) -> None:
        self.path, self._opened = Path(folder) / NAME, False
        self.event_metadata: Callable[[], Mapping[str, str]] = dict
        """Gives what is entered about the campaign with each event, in the same write to the disk."""
        try:
            self._base = sqlite3.connect(self.path, isolation_level=None)
            self._base.execute("PRAGMA synchronous = FULL")
            self._base.executescript(TABLES)
            self._check_schema()
            self._base.execute(f"SELECT {', '.join(COLUMNS)} FROM tests, events").close()
        except FileError:
            raise
        except (sqlite3.Error, ValueError) as problem:
            raise FileError(self.path, self._reason(problem)) from problem
        self._opened = True

    @property
    def origin(self) -> Origin:
        """Origin of the records, as the campaign was run."""
        return as_origin(self.get_metadata("origin") or NOT_STATED.kind)

    def _check_schema(self) -> None:
        version = self.get_metadata("schema")
        if version and int(version) > SCHEMA:
            raise FileError(self.path, f"has the schema {version}, this dampyr knows schema {SCHEMA}; upgrade dampyr")
        if not version:
            self.set_metadata({"schema": str(SCHEMA)})

    def _reason(self, problem: Exception) -> str:
        """Why the journal cannot be used, and the repair."""
        code = getattr(problem, "sqlite_errorcode", 0) & 0xFF
        if self._opened and not self.path.is_file():
            return f"is not there any more: its folder was moved or deleted; move it back, or give its new place, and {GOES_ON}"
        if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            return f"is locked by another program, which may be looking at it; close that program, and {GOES_ON}"
        if code in UNWRITABLE:
            return f"cannot be written, as if it or its folder were read-only ({problem}); make both writable, and {GOES_ON}"
        if code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
            return f"cannot be written ({problem}); see to the disk, and {GOES_ON}"
        return f"is not the journal of a campaign, or is broken ({problem}); {REPAIR}"

    def _rows(self, query: str, values: tuple[object, ...] = ()) -> list[Any]:
        """What the journal answers; :class:`FileError` where it cannot be read."""
        try:
            return self._base.execute(query, values).fetchall()
        except sqlite3.Error as problem:
            raise FileError(self.path, self._reason(problem)) from problem

    def get_metadata(self, key: str) -> str:
        """What is entered about the campaign under ``key``; empty where nothing is."""
        rows = self._rows("SELECT value FROM campaign WHERE key = ?", (key,))
        return str(rows[0][0]) if rows else ""

    def set_metadata(self, metadata: dict[str, str]) -> None:
        """Enter what is known about the campaign, in the place of what was entered under the same keys."""
        with self._transaction():
            self._base.executemany("INSERT OR REPLACE INTO campaign VALUES (?, ?)", metadata.items())

    @property
    def is_empty(self) -> bool:
        """Whether it holds no plan: it is new, or was lost."""
        return not self.get_metadata("digest") or not self.tests()

    def check(self, digest: str, difference: str = "") -> None:
        """Raise :class:`InputError` where the folder belongs to another plan; ``difference`` says what differs."""
        saved = self.get_metadata("digest")
        if saved and saved != digest:
            what = f": {difference}" if difference else ""
            name = self.get_metadata("name")
            raise InputError(
                f"{self.path.parent} holds the campaign {name!r}, and this one differs{what}; give another --out"
            )

    def plan(
        self, digest: str, names: Iterable[str], metadata: dict[str, str], recorded: Iterable[JournalEntry] = ()
    ) -> None:
        """Enter the plan where none is, with what is known of its tests; :class:`InputError` where there is another one."""
        self.check(digest)
        if self.is_empty:
            with_files = {entry.name: entry for entry in recorded}
            entries = [with_files.get(name, JournalEntry(name, "planned", 0, "")) for name in names]
            rows = [
                (entry.name, place, entry.state, entry.attempt, entry.reason) for place, entry in enumerate(entries)
            ]
            with self._transaction():
                self._base.executemany("INSERT OR REPLACE INTO tests VALUES (?, ?, ?, ?, ?)", rows)
                metadata = metadata | {"digest": digest}
                self._base.executemany("INSERT OR REPLACE INTO campaign VALUES (?, ?)", metadata.items())

    def repeat(self, name: str) -> None:
        """A test is to be recorded again, whatever became of it."""
        with self._transaction():
            self._base.execute(
                "UPDATE tests SET state = 'planned', reason = 'to be recorded again' WHERE name = ?", (name,)
            )
            self._enter_event(name, 0, "again", "asked for by its name")

    def tests(self) -> list[JournalEntry]:
        """All tests in their order."""
        rows = self._rows("SELECT name, state, attempt, reason FROM tests ORDER BY place")
        return [JournalEntry(*row) for row in rows]

    def begin(self, name: str, last: int = 0) -> int:
        """A test begins: which try it is, from 1; ``last`` is the highest that has a file."""
        with self._transaction():
            self._base.execute(
                "UPDATE tests SET state = 'running', attempt = max(attempt, ?) + 1, reason = '' WHERE name = ?",
                (last, name),
            )
            attempt = int(self._base.execute("SELECT attempt FROM tests WHERE name = ?", (name,)).fetchone()[0])
            self._enter_event(name, attempt, "begun", "")
        return attempt

    def end(self, name: str, state: TestState, reason: str = "") -> None:
        """A test has ended."""
        with self._transaction():
            self._base.execute("UPDATE tests SET state = ?, reason = ? WHERE name = ?", (state, reason, name))
            attempt = int(self._base.execute("SELECT attempt FROM tests WHERE name = ?", (name,)).fetchone()[0])
            self._enter_event(name, attempt, state, reason)

    def note(self, what: str, detail: str = "", test: str = "", attempt: int = 0) -> None:
        """Enter an event."""
        with self._transaction():
            self._enter_event(test, attempt, what, detail)

    def events(self) -> list[Event]:
        """Everything that happened, oldest first."""
        rows = self._rows("SELECT time, test, attempt, what, detail FROM events ORDER BY id")
        return [Event(*row) for row in rows]

    def close(self) -> None:
        """Let go of the file."""
        self._base.close()

    def _enter_event(self, test: str, attempt: int, what: str, detail: str) -> None:
        self._base.execute(
            "INSERT INTO events (time, test, attempt, what, detail) VALUES (?, ?, ?, ?, ?)",
            (now(), test, attempt, what, detail),
        )
        self._base.executemany("INSERT OR REPLACE INTO campaign VALUES (?, ?)", self.event_metadata().items())

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All of it or nothing, on the disk when it ends; :class:`FileError` where the disk takes nothing."""
        try:
            self._base.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._base.execute("COMMIT")
            except BaseException:
                with suppress(sqlite3.Error):
                    self._base.execute("ROLLBACK")
                raise
        except sqlite3.Error as problem:
            raise FileError(self.path, self._reason(problem)) from problem


def journal_origin(folder: str | Path) -> Origin:
    """Origin of the records of a campaign's folder, as its journal states it."""
    with closing(Journal(folder)) as journal:
        return journal.origin


def read_journal(folder: str | Path) -> tuple[list[JournalEntry], list[Event]]:
    """The tests and events of a campaign's folder."""
    if not (Path(folder) / NAME).is_file():
        raise InputError(f"{folder} has no {NAME}; it is not the folder of a campaign that dampyr ran")
    with closing(Journal(folder)) as journal:
        return journal.tests(), journal.events()
