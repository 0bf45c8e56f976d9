"""Report of a run, its certificate: the page that a command of dampyr writes of its records, in a process of its own."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
import tomllib
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from dampyr.campaigns.journal import Journal
from dampyr.errors import InputError

LIMIT = 600.0  # s that the report may take
BEHIND = ["nice", "-n", "10"] if shutil.which("nice") else []  # the report does not hold up what runs next
ACCEPTANCE, PROTOCOL, CYCLES = "acceptance.html", "protocol.html", "cycles.html"
REPORTS = (ACCEPTANCE, PROTOCOL, CYCLES)
"""The files that a report can be, what judges before what tells."""
ONE = threading.Lock()  # report is written at a time: each takes a core


@dataclass(frozen=True)
class RunReport:
    """The page at ``path`` in the folder of a run, and the words of ``dampyr`` that write it."""

    path: Path
    words: tuple[str, ...]

    def write(self) -> str:
        """Write it; why that failed, empty where it did not."""
        command = [sys.executable, "-m", "dampyr", *self.words, "--report", str(self.path)]
        try:
            done = subprocess.run([*BEHIND, *command], capture_output=True, text=True, timeout=LIMIT, check=False)
        except (OSError, subprocess.TimeoutExpired) as problem:
            return f"no report: {problem}"
        if done.returncode in (0, 1, 3) and self.path.is_file():  # its verdict is in the page
            return ""
        return f"no report: {(done.stderr.strip().splitlines() or ['it ended without a word'])[-1]}"


def report_of(folder: Path) -> Path:
    """The report in the folder of a run; where there is none that is newer than its records, it is written now.

    Raises :class:`~dampyr.errors.InputError` where nothing can be reported, such as of a run without a record.
    """
    with ONE:
        newest = max((path.stat().st_mtime for path in folder.glob("*.h5")), default=0.0)
        for name in REPORTS:
            path = folder / name
            if path.is_file() and not path.is_symlink() and path.stat().st_mtime >= newest:
                return path
        reports = [RunReport(folder / CYCLES, ("cycles", str(folder)))]
        if has_protocol(folder):  # one of a kind without figures of its own is refused, and has those of its cycles
            reports.insert(0, RunReport(folder / PROTOCOL, ("protocol", str(folder))))
        for report in reports:
            why = report.write()
            if not why:
                return report.path
        raise InputError(why)


def has_protocol(folder: Path) -> bool:
    """Whether the campaign of a run states a protocol, by which its records are judged."""
    with closing(Journal(folder)) as journal:
        return "protocol" in tomllib.loads(journal.get_metadata("source"))
