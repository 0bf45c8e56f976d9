"""What the files in a campaign's folder say of its tests, where its journal is missing or empty."""

from __future__ import annotations

import re
from pathlib import Path

from dampyr.campaigns.journal import Entry, TestState
from dampyr.campaigns.plan import Plan, PlannedTest
from dampyr.campaigns.record_test import as_json
from dampyr.errors import FileError
from dampyr.records.formats import h5

INTERRUPTED = "interrupted: the host was killed or lost its power"
REPAIR = "give another --out, or move the files that are there to another folder"


def recorded(folder: Path, campaign_plan: Plan) -> list[Entry]:
    """The tests of a plan that have files in ``folder``: complete where one of them is.

    Raises :class:`~dampyr.errors.FileError` where a file is of another campaign or cannot be read.
    """
    planned = {test.name: test for test in campaign_plan.tests}
    tries: dict[str, list[tuple[h5.State, dict[str, str]]]] = {}
    for path in sorted(filter(Path.is_file, folder.glob("[!.]*.h5"))):
        try:
            state, provenance = h5.state(path), h5.provenance(path)
        except FileError as problem:
            raise FileError(
                folder, f"has no journal of its tests, and a file cannot be read: {problem}; {REPAIR}"
            ) from None
        why = _difference(campaign_plan, planned.get(state.test), provenance)
        if why:
            raise FileError(
                folder,
                f"has no journal of its tests, and its file {path.name} is not of the campaign "
                f"{campaign_plan.campaign.header.name!r}: {why}; {REPAIR}",
            )
        tries.setdefault(state.test, []).append((state, provenance))
    return [_entry(name, tries[name]) for name in planned if name in tries]


def _difference(campaign_plan: Plan, test: PlannedTest | None, provenance: dict[str, str]) -> str:
    """Why a file is not of this plan; empty where it is. Files of before 2026-11-22 tell their own step only."""
    digest = provenance.get("campaign_digest", "")
    if digest:
        return "" if digest == campaign_plan.campaign.digest else "what it runs differs"
    if test is None:
        return "it has no such test"
    if provenance.get("kind") != test.kind or provenance.get("step") != as_json(test.step):
        return "its step differs, or is not told"
    return ""


def _entry(name: str, tries: list[tuple[h5.State, dict[str, str]]]) -> Entry:
    complete = [state.attempt for state, _ in tries if state.complete]
    if complete:
        return Entry(name, "complete", max(complete), "by its file: the journal was lost")
    last, provenance = max(tries, key=lambda each: each[0].attempt)
    how: TestState = "stopped" if provenance.get("exit_status") in ("stopped", "aborted") else "failed"
    return Entry(name, how, last.attempt, provenance.get("reason") or INTERRUPTED)


def last_try(folder: Path, name: str) -> int:
    """The highest try of a test that has a file; 0 where none has."""
    numbers = [
        re.fullmatch(r"(?:\.try(\d+))?\.h5", path.name[len(name) :])
        for path in folder.glob("*.h5")
        if path.name.startswith(name)
    ]
    return max((int(number[1] or 1) for number in numbers if number), default=0)
