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
PAGE = REPOSITORY / "docs" / "reference" / "endurance.md"
_endured: list[tuple[str, str, str, str]] = []


def count(in_full: int, part: int = 20) -> int:
    """How often, of so many times in full: a twentieth of it, or the ``part``-th, but for ``--endure``."""
    return in_full if FULL else max(1, in_full // part)


@dataclass
class Endurance:
    """How often a long campaign repeats what it does, and what it counted: in full with ``--endure``, else a twentieth."""

    name: str
    full: bool = FULL

    def count(self, in_full: int, part: int = 20) -> int:
        """How often, of so many times in full; ``part`` is more than 20 where each time is long."""
        return count(in_full, part)

    def report(self, what: str, seed: int | None, figures: str) -> None:
        """What came out, in a sentence."""
        _endured.append((what, "" if seed is None else str(seed), figures, self.name))


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=REPOSITORY, capture_output=True, text=True, check=False).stdout.strip()


def write_page(failed: Sequence[str]) -> None:
    """Write the page of what `make endure` counted: new rows of the tests that ran now, the others' as they were."""
    commit = _git("rev-parse", "--short=10", "HEAD") + (" with changes" if _git("status", "--porcelain", "src") else "")
    machine = f"Python {platform.python_version()}, {platform.system()}, {os.cpu_count()} cores"
    when = f"{commit}, {date.today().isoformat()}, {machine}"
    ran = [*_endured, *(("", "", "**failed**", test) for test in failed)]
    now = {test for *_, test in ran}
    rows = [row for row in _rows_of(PAGE) if row[3].strip("`") not in now]
    rows += [(what, seed, figures, f"`{test}`", when) for what, seed, figures, test in ran]
    page = (
        "# Endurance\n\n"
        "What `make endure` counted when each test was last run by hand: campaigns that are killed, rigs with faults, and\n"
        "the bench in real time. `.ci/run` does a twentieth of each, in simulated time. `make endure` writes this page.\n\n"
        "| what | seed | figures | test | commit, day, machine |\n|---|---|---|---|---|\n"
    )
    PAGE.write_text(
        page + "".join(f"| {' | '.join(row)} |\n" for row in sorted(rows, key=lambda row: row[3].strip("`"))), "utf-8"
    )


def _rows_of(page: Path) -> list[tuple[str, ...]]:
    """The rows of the page as it is, of tests that still have a file."""
    lines = page.read_text("utf-8").splitlines() if page.is_file() else []
    rows = [tuple(cell.strip() for cell in line.strip("|").split("|")) for line in lines if line.startswith("| ")]
    return [row for row in rows[1:] if (REPOSITORY / row[3].strip("`").partition("::")[0]).is_file()]
