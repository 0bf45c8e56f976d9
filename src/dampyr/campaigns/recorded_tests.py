"""What the files in a campaign's folder say of its tests, where its journal is missing or empty."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from dampyr.campaigns.campaign import Test
from dampyr.campaigns.differences import step_differences
from dampyr.campaigns.journal import JournalEntry, TestState
from dampyr.campaigns.planned_tests import Plan
from dampyr.errors import FileError, InputError
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.formats import h5

INTERRUPTED = "interrupted: the host was killed or lost its power"
BROKEN = ".broken"  # behind the name of a file that nobody can read, so that no reader takes it for a record
REPAIR = "give another --out, or move the files that are there to another folder"


def entries_from_files(folder: Path, campaign_plan: Plan) -> list[JournalEntry]:
    """The entries of the tests of a plan that have files in ``folder``: complete where one of them is.

    Raises :class:`~dampyr.errors.FileError` where a file is of another campaign or cannot be read.
    """
    planned = {test.name: test for test in campaign_plan.campaign.tests}
    tries: dict[str, list[tuple[h5.FileState, dict[str, str]]]] = {}
    for path in sorted(filter(Path.is_file, folder.glob("[!.]*.h5"))):
        try:
            state, provenance = h5.state(path), h5.provenance(path)
        except FileError as problem:
            again = [f"record it again with --again {name}, or " for name in planned if _try_of(path, name)]
            raise FileError(
                folder,
                f"has no journal of its tests, and a file cannot be read: {problem}; {''.join(again)}{REPAIR}",
            ) from None
        why = _describe_difference(campaign_plan, planned.get(state.test), provenance)
        if why:
            raise FileError(
                folder,
                f"has no journal of its tests, and its file {path.name} is not of the campaign "
                f"{campaign_plan.campaign.header.name!r}: {why}; {REPAIR}",
            )
        tries.setdefault(state.test, []).append((state, provenance))
    return [_entry_of_tries(name, tries[name]) for name in planned if name in tries]


def _describe_difference(campaign_plan: Plan, test: Test | None, provenance: dict[str, str]) -> str:
    """Why a file is not of this plan; empty where it is. Files of before 2026-11-22 tell their own step only."""
    campaign, digest = campaign_plan.campaign, provenance.get("campaign_digest", "")
    if digest in (campaign.digest, campaign.path_digest):
        return ""
    if test is None:
        return "it has no such test"
    if provenance.get("kind") != test.kind or "step" not in provenance:
        return "its step differs, or is not stated"
    step = step_differences(provenance["step"], test)
    if digest and not step:
        return "other tests of it, their order, or what is in its files differ"
    return f"its step differs: {step}" if step else ""


def file_of(folder: Path, name: str, attempt: int) -> Path:
    """The file of a try of a test."""
    return folder / (f"{name}.h5" if attempt == 1 else f"{name}.try{attempt}.h5")


def entries_with_files(entries: Iterable[JournalEntry], folder: Path) -> list[JournalEntry]:
    """The entries of a journal with what has become of the files: a complete test whose file is lost is gone or broken."""
    return [_entry_with_file(entry, file_of(folder, entry.name, entry.attempt)) for entry in entries]


def _entry_with_file(entry: JournalEntry, path: Path) -> JournalEntry:
    if entry.state != "complete":
        return entry
    try:
        status = path.stat()
    except OSError:
        return replace(entry, state="gone", reason=f"its file {path.name} is not there")
    if _is_broken_unchanged(path, status.st_size, status.st_mtime_ns):
        return replace(entry, state="broken", reason=f"its file {path.name} cannot be read")
    return entry


@lru_cache(maxsize=4096)
def _is_broken_unchanged(path: Path, size: int, changed: int) -> bool:
    """`is_broken` of a file of that size, changed at that time: pages list hundreds of them again and again."""
    return is_broken(path)


def describe_lost(entries: Iterable[JournalEntry]) -> str:
    """A sentence on the entries that are gone or broken, with the repair; empty where there are none."""
    lost = [entry for entry in entries if entry.state in ("gone", "broken")]
    if not lost:
        return ""
    files = ", ".join(f"{entry.name} ({entry.state})" for entry in lost[:3])
    more = f" and {len(lost) - 3} more" if len(lost) > 3 else ""
    command = " ".join(f"--again {entry.name}" for entry in lost)
    return f"files of complete tests cannot be read: {files}{more}; run the same command with {command} to record them again"


def set_aside(path: Path) -> Path:
    """Give a broken file a name under which nobody takes it for a record; nothing of it is lost."""
    number, aside = 1, path.with_name(path.name + BROKEN)
    while aside.exists():
        number, aside = number + 1, path.with_name(f"{path.name}{BROKEN}{number + 1}")
    path.rename(aside)
    return aside


def broken_tries(folder: Path, name: str) -> list[Path]:
    """The files of a test that cannot be read, or hold something else than was written."""
    return [path for path in sorted(folder.glob("*.h5")) if _try_of(path, name) and _is_damaged(path)]


def _is_damaged(path: Path) -> bool:
    """Whether a file cannot be read as a record, though it has samples enough."""
    try:
        h5.read(path, ReadOptions())
    except h5.FewSamples:
        return False
    except InputError:
        return True
    return False


def is_broken(path: Path) -> bool:
    """Whether a file is there and is truncated or does not hold a record."""
    try:
        h5.state(path)
    except h5.BrokenFile:
        return True
    return False


def remove_parts(folder: Path, names: Iterable[str]) -> None:
    """Remove what hosts that were killed while they finished a file of these tests have left of the new one."""
    tests = set(names)
    for path in folder.glob(".*.h5.*.part"):
        name = re.fullmatch(r"\.(.+?)(?:\.try\d+)?\.h5\.\w+\.part", path.name)
        if name and name[1] in tests:
            path.unlink(missing_ok=True)


def _entry_of_tries(name: str, tries: list[tuple[h5.FileState, dict[str, str]]]) -> JournalEntry:
    complete = [state.attempt for state, _ in tries if state.complete]
    if complete:
        return JournalEntry(name, "complete", max(complete), "by its file: the journal was lost")
    last, provenance = max(tries, key=lambda saved: saved[0].attempt)
    ended: TestState = "stopped" if provenance.get("exit_status") in ("stopped", "aborted") else "failed"
    return JournalEntry(name, ended, last.attempt, provenance.get("reason") or INTERRUPTED)


def last_try(folder: Path, name: str) -> int:
    """The highest try of a test that has a file, broken ones included; 0 where none has."""
    return max((_try_of(path, name) for path in folder.glob("*.h5*")), default=0)


def _try_of(path: Path, name: str) -> int:
    """Which try of the test ``name`` a file is, by its own name; 0 where it is not one."""
    number = re.fullmatch(rf"(?:\.try(\d+))?\.h5(?:{re.escape(BROKEN)}\d*)?", path.name.removeprefix(name))
    return int(number[1] or 1) if path.name.startswith(name) and number else 0
