"""Reference of a run: an earlier run of the same tests, compared live and judged by ``dampyr accept`` at the end."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
from dataclasses import dataclass, field, replace
from pathlib import Path

from dampyr.campaigns.run_control import Progress
from dampyr.console.bench_reference import MAX_CYCLES, Comparison, CycleJudge, ReferenceLoop, reference_test
from dampyr.errors import DampyrError

REPORT = "acceptance.html"
LIMIT = 600.0  # s that the report may take
BEHIND = ["nice", "-n", "10"] if shutil.which("nice") else []  # the report does not hold up what runs next


@dataclass
class RunReference:
    """The folder of the earlier run and the tolerance, a ratio."""

    folder: Path
    tolerance: float
    comparison: Comparison = field(init=False)
    loop: ReferenceLoop | None = None
    """The loop of the test under way, for drawing."""
    _judge: CycleJudge | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def __post_init__(self) -> None:
        self.comparison = Comparison(self.folder.name, self.tolerance)

    def take(self, progress: Progress) -> None:
        """Compare what has come of a test."""
        if progress.samples is None or progress.phase != "testing":
            return
        if progress.name != self.comparison.test:
            self._begin(progress.name)
        with self._lock:
            judge = self._judge
        judged = judge.take(progress.samples) if judge is not None else []
        if judged:
            passed = sum(cycle.passed for cycle in judged)
            before = self.comparison
            self.comparison = replace(
                before,
                passed=before.passed + passed,
                failed=before.failed + len(judged) - passed,
                cycles=(*before.cycles, *judged)[-MAX_CYCLES:],
            )

    def _begin(self, test: str) -> None:
        """Read the reference of a test, in a thread: a disk that hesitates holds nothing up. What comes before that is not
        judged.
        """
        with self._lock:
            self._judge, self.loop = None, None
        self.comparison = Comparison(self.folder.name, self.tolerance, test, "its reference is being read")
        threading.Thread(target=self._read, args=(test,), name="reference", daemon=True).start()

    def _read(self, test: str) -> None:
        try:
            reference, reason = reference_test(self.folder, test), ""
        except (DampyrError, OSError) as problem:
            reference, reason = None, str(problem)
        with self._lock:
            if self.comparison.test == test:
                self.comparison = replace(self.comparison, reason=reason)
                self._judge = CycleJudge(reference, self.tolerance) if reference else None
                self.loop = reference.loop if reference else None

    def write_report(self, folder: Path) -> str:
        """Judge the records in ``folder`` and write the report there; why that failed, empty where it did not."""
        command = [
            sys.executable, "-m", "dampyr", "accept", str(self.folder), str(folder), "--tolerance", f"{self.tolerance:g}",
            "--report", str(folder / REPORT),
        ]  # fmt: skip
        try:
            done = subprocess.run([*BEHIND, *command], capture_output=True, text=True, timeout=LIMIT, check=False)
        except (OSError, subprocess.TimeoutExpired) as problem:
            return f"no report: {problem}"
        if done.returncode in (0, 1, 3) and (folder / REPORT).is_file():  # its verdict is in the page
            return ""
        return f"no report: {(done.stderr.strip().splitlines() or ['it ended without a word'])[-1]}"
