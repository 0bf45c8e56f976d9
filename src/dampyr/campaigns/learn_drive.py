"""Learning of a test's drive on the rig: tries, each recorded in a file of its own, until one is good enough or none helps.

In the campaign's folder, ``learning/NAME.iteration1.h5`` is the record of the first try and ``learning/NAME.iteration1.csv``
what was wanted and commanded in it. Tries that are complete there count, and are not repeated, as long as rig, specimen and
wanted drive are the same. What the next try commands follows from the last one's files alone, so that a run that was
interrupted goes on as if it had not been.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.campaigns.campaign_thresholds import USUAL, CampaignThresholds
from dampyr.campaigns.check import violations_of
from dampyr.campaigns.journal import Journal, now
from dampyr.campaigns.learned_drives import FOLDER, LearnedDrive, drive_key, load_learned, save_learned
from dampyr.campaigns.learning import (
    LIMITS,
    TRIES,
    Array,
    Tracking,
    at_set_points,
    best_of,
    ended_because,
    next_set_points,
    tracking,
)
from dampyr.campaigns.planned_tests import Plan, PlannedTest
from dampyr.campaigns.record_test import take
from dampyr.campaigns.step import Peaks
from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.files.recording import Recording
from dampyr.records.formats import h5
from dampyr.rig import Drive, RigSettings
from dampyr.rig.interlock import Samples
from dampyr.rig.session import ArmedRig

TRIES_FOLDER = "learning"
COLUMNS = "time [s],wanted [m],commanded [m],voltage [V]"
KEY, ERROR, RMS = "learning_key", "learning_error", "learning_rms"
OnSamples = Callable[[Samples], None]


@dataclass(frozen=True)
class DriveAsStep:
    """A drive in the place of a step, for the check: its peaks are those of its set points."""

    set_points: Drive

    def drive(self, rig: RigSettings) -> Drive:
        """The drive."""
        return self.set_points

    def peaks(self, rig: RigSettings) -> Peaks:
        """The farthest set point, and the greatest speed from one to the next."""
        x = self.set_points.displacement
        return Peaks(float(np.abs(x).max()), float(np.abs(np.diff(x)).max()) / self.set_points.period)


@dataclass(frozen=True, eq=False)
class Try:
    """A complete try: its number in the folder, what it commanded and achieved (n,) [m], and how far off that is."""

    number: int
    commanded: Array
    achieved: Array
    tracking: Tracking


@dataclass(frozen=True, eq=False)
class Learned:
    """How learning ended: the best drive, the file of its set points, the error of each try, and why it ended."""

    drive: Drive
    file: str
    errors: tuple[float, ...]
    reason: str
    origin: str

    @property
    def provenance(self) -> dict[str, str]:
        """What the record of the test says of it."""
        return {
            "learning_tries": str(len(self.errors)),
            "learning_errors": ", ".join(f"{error:.6f}" for error in self.errors),
            "learning_error_before": f"{self.errors[0]:.6f}",
            "learning_error_best": f"{min(self.errors):.6f}",
            "learning_ended": self.reason,
            "learning_started_from": self.origin,
            "learning_drive": self.file,
        }

    @property
    def words(self) -> str:
        """In one line, such as ``5.04 %, 0.86 % in 2 tries, ended: within 2 %``."""
        errors = ", ".join(map(percent, self.errors))
        return f"{errors} in {len(self.errors)} {'try' if len(self.errors) == 1 else 'tries'}, ended: {self.reason}"


def percent(error: float) -> str:
    """An error for people."""
    return f"{100 * error:.2f} %"


@dataclass
class PlayJudge:
    """Judges the samples of one play of ``wanted``; ``result`` is its `Tracking`, where there is one."""

    wanted: Drive
    result: Tracking | None = None

    def __call__(self, recording: Recording) -> dict[str, str]:
        """What the record says of how far it is off."""
        time, x = (recording.read(f"calibrated/{name}") for name in ("time", "displacement"))
        try:
            self.result = tracking(self.wanted, at_set_points(self.wanted, time, x))
        except (InputError, IndexError) as problem:  # a record without its error is still a record
            return {ERROR: f"not known: {problem}"}
        return {ERROR: f"{self.result.error:.6f}", RMS: f"{self.result.rms:.6f}"}


@dataclass
class DriveLearning:
    """Learning of one test's drive, on a table that is armed.

    ``play`` gives what is called with the samples of a try, from its number and the last error, None before the first.
    ``provenance`` is what the record of each try says besides.
    """

    table: ArmedRig
    plan: Plan
    test: PlannedTest
    folder: Path
    attempt: int
    journal: Journal
    groups: Mapping[str, str]
    provenance: Mapping[str, str]
    play: Callable[[int, float | None], OnSamples]
    thresholds: CampaignThresholds = USUAL
    tries: list[Try] = field(default_factory=list)
    origin: str = "the wanted drive"
    _next_points: Array | None = None

    def __post_init__(self) -> None:
        rig = self.table.rig
        self.key = drive_key(self.wanted, rig.settings, self.groups)
        self.tries_folder = self.folder / TRIES_FOLDER
        self.store = (rig.folder or self.tries_folder) / FOLDER

    @property
    def wanted(self) -> Drive:
        """The drive that the table is to follow."""
        return self.test.drive

    @property
    def trackings(self) -> tuple[Tracking, ...]:
        """Of the tries, in their order."""
        return tuple(done.tracking for done in self.tries)

    @property
    def errors(self) -> tuple[float, ...]:
        """Of the tries, in their order."""
        return tuple(result.error for result in self.trackings)

    def learn(self) -> Learned:
        """Try until learning ends; the best drive. What ends a try early is raised again."""
        self.table.meanwhile(self._begin)
        while not (reason := ended_because(self.trackings)):
            if limit := self._describe_limit():
                reason = f"{LIMITS}: the next drive {limit}"
                break
            self._record_try()
            self.table.rest(self.plan.campaign.header.rest_between)
        best = self.tries[best_of(self.trackings)]
        drive = replace(self.wanted, displacement=best.commanded)
        file = f"{TRIES_FOLDER}/{self._path(best.number, 'csv').name}"
        learned = Learned(drive, file, self.errors, reason, self.origin)
        self.journal.note("learned", learned.words, self.test.name, self.attempt)
        self.table.meanwhile(lambda: self._save(best))
        return learned

    def _begin(self) -> None:
        """Read the tries that are there; what the first one commands where there is none."""
        try:
            self.tries_folder.mkdir(exist_ok=True)
        except OSError as problem:
            raise FileError(
                self.tries_folder, f"cannot be made ({problem.strerror}); make the folder writable"
            ) from problem
        for path in self.tries_folder.glob(f".{self.test.name}.iteration*.part"):
            path.unlink(missing_ok=True)
        self.tries = [done for done in map(self._read_try, self._try_numbers()) if done is not None]
        if self.tries:
            last = h5.provenance(self._path(self.tries[0].number, "h5"))
            self.origin = last.get("learning_started_from", self.origin)
            self._choose_next_points()
            return
        self._next_points = self.wanted.displacement
        learned = load_learned(self.store, self.test.test.kind, self.key, self.wanted)
        if learned is None:
            return
        self._next_points, self.origin = learned.set_points, learned.origin
        if limit := self._describe_limit():
            self.journal.note("learned drive not used", f"it {limit}", self.test.name, self.attempt)
            self._next_points, self.origin = self.wanted.displacement, "the wanted drive"

    def _describe_limit(self) -> str:
        """What the rig cannot do of the next drive; empty where it can do all of it."""
        assert self._next_points is not None
        if np.array_equal(self._next_points, self.wanted.displacement):
            return ""  # the plan has checked it
        step = DriveAsStep(replace(self.wanted, displacement=self._next_points))
        violations = violations_of(step, self.table.rig.settings, self.plan.damper)
        return violations[0].words if violations else ""

    def _record_try(self) -> None:
        """Play the next drive and record it."""
        assert self._next_points is not None
        number = 1 + max(self._try_numbers(), default=0)
        count, last = len(self.tries) + 1, self.errors[-1] if self.tries else None
        name = f"{self.test.name}.iteration{number}"
        drive = replace(self.wanted, displacement=self._next_points)
        planned = replace(self.test, test=replace(self.test.test, name=name), drive=drive)
        path, points = self._path(number, "h5"), self._path(number, "csv")
        self.table.meanwhile(lambda: self._write_drive(points, drive))
        provenance = {
            **self.provenance, "learning_of": self.test.name, "learning_try": f"{count} of {TRIES}", KEY: self.key,
            "learning_drive": points.name, "learning_started_from": self.origin,
        }  # fmt: skip
        judge = PlayJudge(self.wanted)
        on_samples = self.play(count, last)
        take(
            self.table, planned, self.plan.campaign, path, number, self.groups, on_samples, provenance, judge,
            self.thresholds,
        )  # fmt: skip
        self.table.meanwhile(lambda: self._add_try(number))
        result = self.tries[-1].tracking
        words = (
            f"try {count} of {TRIES}: {percent(result.error)}, rms {percent(result.rms)}, {TRIES_FOLDER}/{path.name}"
        )
        self.journal.note("learning", words, self.test.name, self.attempt)

    def _add_try(self, number: int) -> None:
        """Read the try that has just ended as one that an earlier run has left, and prepare the next one."""
        done = self._read_try(number)
        if done is None:
            raise FileError(
                self._path(number, "h5"), "was recorded and cannot be read as a try; run the campaign again"
            )
        self.tries.append(done)
        self._choose_next_points()

    def _choose_next_points(self) -> None:
        """What the next try commands."""
        last = self.tries[-1]
        self._next_points = next_set_points(self.wanted.displacement, last.commanded, last.achieved, self.wanted.period)

    def _save(self, best: Try) -> None:
        """Save the best drive for the next campaign; that it cannot be is a warning."""
        learned = LearnedDrive(self.key, self.test.words, best.commanded, best.tracking, now("seconds"))
        try:
            save_learned(self.store, self.test.test.kind, learned, self.wanted)
        except FileError as problem:
            warnings.warn(f"the learned drive was not saved: {problem}", DampyrWarning, stacklevel=2)
            self.journal.note("learned drive not saved", str(problem), self.test.name, self.attempt)

    def _path(self, number: int, suffix: str) -> Path:
        return self.tries_folder / f"{self.test.name}.iteration{number}.{suffix}"

    def _try_numbers(self) -> list[int]:
        """Of the tries that have left a file, whatever it holds."""
        pattern = re.compile(re.escape(self.test.name) + r"\.iteration(\d+)\..+")
        names = (pattern.fullmatch(path.name) for path in self.tries_folder.iterdir())
        return sorted({int(name[1]) for name in names if name})

    def _read_try(self, number: int) -> Try | None:
        """A try from its files; None where it is not complete, cannot be read, or is one for something else."""
        path = self._path(number, "h5")
        try:
            if not h5.state(path).complete or h5.provenance(path).get(KEY) != self.key:
                return None
            record, raw = h5.read(path, ReadOptions()), h5.read_raw(path)["position"]
            table = np.loadtxt(self._path(number, "csv"), delimiter=",", skiprows=1, ndmin=2)
        except (InputError, OSError, ValueError, KeyError):
            return None
        if table.shape != (self.wanted.n, 4) or not np.all(np.isfinite(table)):
            return None
        achieved = at_set_points(self.wanted, record.time, raw.gain * raw.values + raw.offset)
        return Try(number, table[:, 2], achieved, tracking(self.wanted, achieved))

    def _write_drive(self, path: Path, drive: Drive) -> None:
        """Write what is wanted and commanded in a try, every digit of it."""
        columns = (drive.time.round(6), self.wanted.displacement, drive.displacement, drive.voltage)
        rows = "\n".join(",".join(repr(float(value)) for value in row) for row in zip(*columns, strict=True))
        try:
            write_whole(path, f"{COLUMNS}\n{rows}\n")
        except OSError as problem:
            raise FileError(path, f"cannot be written ({problem.strerror or problem}); make room") from problem
