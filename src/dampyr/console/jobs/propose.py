"""The next tests, as ``dampyr plan`` proposes them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from dampyr.console.equivalent_commands import plan_command
from dampyr.console.jobs import DATA
from dampyr.console.page_tables import page_table
from dampyr.console.page_words import in_page_words
from dampyr.console.proposals import ProposalRequest
from dampyr.console.rigs import rig_file
from dampyr.console.safe_paths import data_of
from dampyr.planning import propose
from dampyr.show.planning.proposal import interval_table


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is a `ProposalRequest`."""
    parsed, data = ProposalRequest(**request), data_of(folder)
    result = propose(parsed.evidence(data), rig_file(data, parsed.rig), parsed.options(), progress, peak=parsed.peak())
    return {
        DATA: result.as_dict(),
        "text": result.text,
        "command": plan_command(parsed),
        "notice": result.origin.notice,
        "notes": [in_page_words(note) for note in result.notes],
        "findings": [in_page_words(finding.sentence) for finding in result.findings],
        "intervals": page_table(interval_table(result)),
    }
