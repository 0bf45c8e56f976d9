"""Reference of a run: an earlier run of the same tests, compared live and judged by ``dampyr accept`` at the end."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from pathlib import Path

from dampyr.campaigns.run_control import Progress
from dampyr.console.bench_reference import Comparison, EarlierRun, LiveComparison, ReferenceLoop
from dampyr.console.run_report import ACCEPTANCE, RunReport
from dampyr.errors import DampyrError
from dampyr.records import read_campaign


@dataclass
class RunReference:
    """The folder of the earlier run and the tolerance, a ratio."""

    folder: Path
    tolerance: float
    _reader: threading.Thread | None = None
    _run: EarlierRun | None = None
    _reason: str = "its reference is being read"
    _live: LiveComparison | None = None
    _testing: bool = False

    @property
    def comparison(self) -> Comparison:
        """How the test under way, or the last one, compares."""
        live = self._live
        if live is None:
            return Comparison(self.folder.name, self.tolerance)
        return replace(live.comparison, reason=self._reason or live.comparison.reason)

    @property
    def loop(self) -> ReferenceLoop | None:
        """The loop of that test in the earlier run, for drawing."""
        return self._run.loops.get(self.comparison.test) if self._run is not None else None

    def take(self, progress: Progress) -> None:
        """Compare what has come of a test. The earlier run is read once, in a thread: a slow disk holds nothing up."""
        if self._reader is None:
            self._reader = threading.Thread(target=self._read, name="reference", daemon=True)
            self._reader.start()
        if progress.samples is None or progress.phase != "testing":
            self._testing = False  # what comes next is another test, or another try of this one
            return
        if not self._testing or self._live is None:
            self._live = LiveComparison(Comparison(self.folder.name, self.tolerance, progress.name))
        self._testing = True
        self._live.take(progress, self._run)

    def _read(self) -> None:
        try:
            self._run, self._reason = EarlierRun.of(read_campaign(self.folder, role=None)), ""
        except (DampyrError, OSError) as problem:
            self._reason = str(problem)

    def report(self, folder: Path) -> RunReport:
        """The report that judges the records in ``folder``."""
        words = ("accept", str(self.folder), str(folder), "--tolerance", f"{self.tolerance:g}")
        return RunReport(folder / ACCEPTANCE, words)
