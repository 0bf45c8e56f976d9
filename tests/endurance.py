"""Long campaigns: how often they repeat what they do, and the page of what they counted."""

import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

FULL = "--endure" in sys.argv
REPOSITORY = Path(__file__).resolve().parents[1]
_endured: list[tuple[str, str, str, str]] = []


def count(in_full: int) -> int:
    """How often, of so many times in full: a tenth of it, but for ``--endure``."""
    return in_full if FULL else max(1, in_full // 10)


@dataclass
class Endurance:
    """How often a long campaign repeats what it does, and what it counted: with ``--endure`` in full, else a tenth of it."""

    name: str
    full: bool = FULL

    def count(self, in_full: int) -> int:
        """How often, of so many times in full."""
        return count(in_full)

    def report(self, what: str, seed: int | None, figures: str) -> None:
        """What came out, in a sentence."""
        _endured.append((what, "" if seed is None else str(seed), figures, self.name))


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=REPOSITORY, capture_output=True, text=True, check=False).stdout.strip()


def write_page(passed: int, failed: Sequence[str]) -> None:
    """Write the page of what `make endure` counted, and which of its tests failed."""
    commit = _git("rev-parse", "--short=10", "HEAD") + (" with changes" if _git("status", "--porcelain", "src") else "")
    rows = "".join(f"| {what} | {seed} | {figures} | `{test}` |\n" for what, seed, figures, test in _endured)
    page = (
        "# Endurance\n\n"
        "What `make endure` counted when it was last run by hand: campaigns that are killed, rigs with faults, and the bench\n"
        "in real time. `.ci/run` does a tenth of each, in simulated time. `make endure` writes this page.\n\n"
        f"Commit {commit}, {date.today().isoformat()}, Python {platform.python_version()}, {platform.system()}, "
        f"{os.cpu_count()} cores.\n\n"
        f"{passed} tests passed{''.join(f', `{test}` failed' for test in failed)}.\n\n"
        f"| what | seed | figures | test |\n|---|---|---|---|\n{rows}"
    )
    (REPOSITORY / "docs" / "reference" / "endurance.md").write_text(page, "utf-8")
