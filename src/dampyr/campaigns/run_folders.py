"""State of the folders that campaigns were run into: complete, interrupted, under way, or of another campaign."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from dampyr.campaigns.differences import campaign_differences
from dampyr.campaigns.folder_lock import folder_lock
from dampyr.campaigns.journal import NAME, Journal
from dampyr.campaigns.planned_tests import Plan
from dampyr.campaigns.recorded_tests import describe_lost, entries_with_files
from dampyr.errors import DampyrError, FileError, InputError
from dampyr.origin import NOT_STATED, Origin

RunState = Literal["complete", "interrupted", "running", "unreadable"]
FolderState = Literal["new", "interrupted", "complete", "foreign", "running"]


@dataclass(frozen=True)
class RunFolder:
    """A folder with a journal: ``complete`` of ``tests`` are recorded; ``time`` of its last event, UTC as ISO 8601."""

    name: str
    campaign: str
    operator: str
    state: RunState
    complete: int
    tests: int
    time: str
    reason: str = ""
    origin: Origin = NOT_STATED


def run_folder(folder: str | Path) -> RunFolder:
    """What the journal of a folder says; a journal that cannot be read is a state with its reason."""
    folder = Path(folder)
    try:
        with closing(Journal(folder)) as journal:
            entries, events = entries_with_files(journal.tests(), folder), journal.events()
            campaign, operator = journal.get_metadata("name"), journal.get_metadata("operator")
            origin = journal.origin
    except DampyrError as problem:
        return RunFolder(folder.name, "", "", "unreadable", 0, 0, "", str(problem))
    complete = sum(entry.state == "complete" for entry in entries)
    state: RunState = "complete" if entries and complete == len(entries) else "interrupted"
    if state == "interrupted" and is_locked(folder):
        state = "running"
    ended = [event.detail for event in events if event.what in ("ended early", "ended")]
    ended += filter(None, [describe_lost(entries)])
    last = events[-1].time if events else ""
    return RunFolder(
        folder.name,
        campaign,
        operator,
        state,
        complete,
        len(entries),
        last,
        ended[-1] if ended and state == "interrupted" else "",
        origin,
    )


def is_locked(folder: Path) -> bool:
    """Whether a host runs a campaign into a folder now."""
    try:
        with folder_lock(folder):
            return False
    except (InputError, FileError):
        return True


def folder_state(campaign_plan: Plan, folder: str | Path) -> tuple[FolderState, str]:
    """What running a plan into a folder would mean, with a sentence for a person; nothing is written."""
    folder = Path(folder)
    if not (folder / NAME).is_file():
        return "new", "a new folder"
    with closing(Journal(folder)) as journal:
        entries, digest = entries_with_files(journal.tests(), folder), journal.get_metadata("digest")
        name, contents = journal.get_metadata("name"), journal.get_metadata("contents")
    campaign = campaign_plan.campaign
    if digest and digest not in (campaign.digest, campaign.path_digest):
        difference = campaign_differences(contents, [entry.name for entry in entries], campaign)
        what = f" ({difference})" if difference else ""
        return "foreign", f"it holds the campaign {name!r}, which is another one{what}; choose another folder"
    if is_locked(folder):
        return "running", "a campaign runs into it now; wait, or choose another folder"
    complete = sum(entry.state == "complete" for entry in entries)
    if entries and complete == len(entries):
        return (
            "complete",
            f"all {complete} tests are recorded there; choose another folder to run them again, or repeat some of them",
        )
    if lost := describe_lost(entries):
        return "interrupted", f"{complete} of {len(entries)} tests are recorded there; {lost}"
    return "interrupted", f"{complete} of {len(entries)} tests are recorded there; the others are run"
