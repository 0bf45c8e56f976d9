"""Performance of a campaign: checked as a whole, then test by test, each in a file of its own, resumed where it stopped."""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import partial
from pathlib import Path

from dampyr.campaigns.campaign import Campaign, read
from dampyr.campaigns.campaign_thresholds import USUAL, CampaignThresholds
from dampyr.campaigns.differences import campaign_differences, contents_of, settings_differences
from dampyr.campaigns.folder_lock import folder_lock
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.journal import Journal, now
from dampyr.campaigns.learn_drive import DriveLearning, Learned, OnSamples, PlayJudge, percent
from dampyr.campaigns.learning import TRIES
from dampyr.campaigns.monitor import Watch, time_left
from dampyr.campaigns.pass_marks import agreeing_passes, describe_comparison, differs_from_earlier_runs, pass_to_compare
from dampyr.campaigns.planned_tests import Plan, PlannedTest, plan
from dampyr.campaigns.preliminary import preliminary_check
from dampyr.campaigns.protocol_result import protocol_text
from dampyr.campaigns.record_test import as_json, check_disk, groups_of, reason, take
from dampyr.campaigns.recorded_campaign import RecordedCampaign
from dampyr.campaigns.recorded_tests import (
    INTERRUPTED,
    broken_tries,
    describe_lost,
    entries_from_files,
    entries_with_files,
    file_of,
    is_broken,
    last_try,
    remove_parts,
    set_aside,
)
from dampyr.campaigns.run_control import EndedByProtocol, Progress, RunControl, Skipped, Stopped
from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.origin import as_origin, combined
from dampyr.records import read as read_record
from dampyr.records.formats import h5
from dampyr.rig.damper_temperature import SavedTemperature, machine_uptime
from dampyr.rig.interlock import Samples
from dampyr.rig.session import ArmedRig, Rig
from dampyr.rig.slow_passes import SlowPass, with_run
from dampyr.rig.uncertainty_budget import Evidence

Watcher = Callable[[Progress], None]
SAVE_EVERY = 2.0  # s between two times that the damper's temperature is saved: at 300 W it rises by 1.3 K
TEMPERATURE, TEMPERATURE_TIME, TEMPERATURE_UPTIME = "temperature_degC", "temperature_time", "temperature_uptime"


def perform(
    campaign: Plan | Campaign | str | Path,
    rig: Rig,
    folder: str | Path,
    progress: Watcher | None = None,
    control: RunControl | None = None,
    again: Sequence[str] = (),
    thresholds: CampaignThresholds | None = None,
) -> RecordedCampaign:
    """Run a campaign on a connected rig; its folder holds a file per test and the journal. The records are what it returns.

    Parameters
    ----------
    campaign
        A plan, a campaign, or the path of its TOML file. Refused as a whole where the rig cannot do all of it.
    folder
        Where the records go. Tests that are complete there are not run again; one that was interrupted is run anew,
        beside what it left. Where its journal is missing or empty the files say which tests are complete. While a campaign
        runs, its folder is locked.
    progress
        Called with a :class:`Progress` for every block of samples.
    control
        The buttons: pause, resume, stop, abort.
    again
        Names of tests that are recorded again, each as a further try, although they are complete. A file of them that is
        broken is renamed, so that it is not read as a record.
    thresholds
        When what a test shows of itself becomes a mark of its record, or ends the campaign; None: the usual values.

    Returns
    -------
    RecordedCampaign
        The records of the complete tests in ``folder``, the latest try of each.

    Raises
    ------
    InputError
        Before anything moves: the rig cannot do a test, the folder holds another campaign, or the damper has to cool first.
    RigFault
        A safety layer has acted, or a mark has spoiled a test.
    Stopped
        It was asked for; or, as its kind `EndedByProtocol`, the protocol has come to its end, such as a decay of the force.
    FileError
        The disk is full, or the file of a complete test is gone or broken: what is left is run, after a warning, before.

    In every case the table is at rest, the coil at 0 V, and the journal records the reason.

    Warns
    -----
    DampyrWarning
        Settings of the rig differ from those that the campaign was begun with: the journal and each further record say how.

    Examples
    --------
    >>> import dampyr as dp
    >>> step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": "1.98 V", "cycles": 2}
    >>> campaign = dp.campaigns.campaign_of({"name": "one", "operator": "me", "step": [step]})
    >>> with dp.rig.simulated() as rig:
    ...     records = dp.campaigns.perform(campaign, rig, "one")
    >>> [record.name for record in records], records.folder.name
    (['01-sine-8mm-1Hz-1.98V'], 'one')
    """
    if isinstance(campaign, Plan):
        campaign_plan = campaign
    else:
        tests_to_run = campaign if isinstance(campaign, Campaign) else read(campaign)
        campaign_plan = plan(tests_to_run, rig.settings, specimen(rig.settings, rig.folder))
    campaign_plan.require()
    names = [test.name for test in campaign_plan.tests]
    for name in again:
        if name not in names:
            raise InputError(f"again = {name!r} is not a test of this campaign; its tests are {_name_first(names)}")
    folder = _make_folder(Path(folder))
    with folder_lock(folder):
        remove_parts(folder, names)
        moved = [set_aside(path) for name in again for path in broken_tries(folder, name)]
        with closing(Journal(folder)) as journal:
            _enter_plan(campaign_plan, rig, journal, folder)
            before = journal.get_metadata("origin")
            origin = combined([rig.origin, *([as_origin(before)] if before else [])])
            if origin.kind != before:  # a complete campaign on a disk that takes nothing is read as it is
                journal.set_metadata({"origin": origin.kind})
            _reconcile(journal, folder)
            for path in moved:
                journal.note("set aside", f"{path.name}: it cannot be read")
            for name in again:
                journal.repeat(name)
            lost = describe_lost(entries_with_files(journal.tests(), folder))
            run = _Run(
                campaign_plan,
                rig,
                folder,
                journal,
                progress or (lambda _: None),
                control or RunControl(),
                thresholds or USUAL,
            )
            if run.remaining_tests():
                if lost:
                    warnings.warn(f"{folder}: {lost}", DampyrWarning, stacklevel=2)
                run.restore_temperature()
                run.kept = rig.kept_passes()
                run.provenance = _note_changed_settings(journal, rig)
                if changed := run.thresholds.changed:
                    run.provenance |= {"thresholds": changed}
                if (protocol := campaign_plan.campaign.protocol) is not None:
                    run.provenance |= {"protocol": protocol_text(campaign_plan.campaign.protocol_kind, protocol)}
                run.perform()
            tests = entries_with_files(journal.tests(), folder)
    if lost := describe_lost(tests):
        complete = sum(entry.state == "complete" for entry in tests)
        raise FileError(folder, f"{complete} of {len(tests)} tests are complete: {lost}")
    return RecordedCampaign(folder)


def _name_first(names: Sequence[str]) -> str:
    """A few names, and how many more there are."""
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _make_folder(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise FileError(folder, f"cannot be made ({problem.strerror}); choose another folder") from problem
    return folder


def _enter_plan(campaign_plan: Plan, rig: Rig, journal: Journal, folder: Path) -> None:
    """Enter the plan; where the journal holds none, with what the files in the folder say of its tests."""
    campaign = campaign_plan.campaign
    names, digest = [test.name for test in campaign_plan.tests], campaign.digest
    if not journal.is_empty:
        saved = journal.get_metadata("digest")
        if saved == campaign.path_digest != digest:  # of before 2026-11-23, when only a motion file's path counted
            journal.set_metadata({"digest": digest, "contents": contents_of(campaign)})
        elif saved != digest:
            entered = [entry.name for entry in journal.tests()]
            journal.check(digest, campaign_differences(journal.get_metadata("contents"), entered, campaign))
        return
    journal.check(digest)
    entries = entries_from_files(folder, campaign_plan)
    journal.plan(digest, names, _metadata(campaign_plan, rig, folder), entries)
    if entries:
        complete = sum(entry.state == "complete" for entry in entries)
        source = f"from the files of {len(entries)} of its {len(names)} tests: "
        source += f"{complete} complete, {len(entries) - complete} not"
        journal.note("rebuilt", source)
        warnings.warn(f"{journal.path} was missing or empty and is made anew {source}", DampyrWarning, stacklevel=3)


def _note_changed_settings(journal: Journal, rig: Rig) -> dict[str, str]:
    """Warn of settings that are not those that the campaign was begun with; what its further records say of it."""
    saved = journal.get_metadata("rig")
    difference = settings_differences(saved, rig.settings) if saved else ""
    if not difference:
        return {}
    journal.note("settings changed", difference)
    warnings.warn(
        f"the rig's settings differ from those that the campaign was begun with: {difference}; the records say so",
        DampyrWarning,
        stacklevel=3,
    )
    return {"rig_changes": difference}


def _metadata(campaign_plan: Plan, rig: Rig, folder: Path) -> dict[str, str]:
    """What the journal says of a campaign; where records are there already, the rig is that of the first of them.

    The first is that of the plan's order and the lowest try: the day's clock may have been set back since.
    """
    head = campaign_plan.campaign.header
    places = {test.name: place for place, test in enumerate(campaign_plan.tests)}
    states = ((path, h5.state(path)) for path in folder.glob("[!.]*.h5"))
    order = sorted(states, key=lambda row: (places.get(row[1].test, len(places)), row[1].attempt))
    first = h5.provenance(order[0][0]) if order else {}
    return {
        "name": head.name,
        "operator": head.operator,
        "note": head.note,
        "source": campaign_plan.campaign.source,
        "contents": contents_of(campaign_plan.campaign),
        "rig": first.get("rig") or as_json(rig.settings),
    }


def _reconcile(journal: Journal, folder: Path) -> None:
    """Make the journal agree with the files: the process that wrote it may have been killed."""
    for entry in journal.tests():
        if entry.state != "running":
            continue
        path = file_of(folder, entry.name, entry.attempt)
        if path.is_file() and is_broken(path):
            journal.end(
                entry.name, "failed", f"{INTERRUPTED}, and its file cannot be read: it is {set_aside(path).name} now"
            )
        elif path.is_file() and h5.state(path).complete:
            journal.end(entry.name, "complete", "found complete after an interruption")
        else:
            journal.end(entry.name, "failed", INTERRUPTED)


@contextmanager
def _noting_trouble(problem: BaseException) -> Iterator[None]:
    """A failed entry in the journal does not hide ``problem``; the files are right without it."""
    try:
        yield
    except FileError as trouble:
        problem.add_note(str(trouble))


@dataclass
class _Run:
    """One run over the tests that are left."""

    plan: Plan
    rig: Rig
    folder: Path
    journal: Journal
    progress: Watcher
    control: RunControl
    thresholds: CampaignThresholds
    groups: Mapping[str, str] = field(default_factory=dict)
    """The session and the specimen of every test of this run."""
    provenance: dict[str, str] = field(default_factory=dict)
    """What the records of this run say besides."""
    kept: tuple[SlowPass, ...] = ()
    """Slow passes of earlier runs with the rig."""
    _saved: float = field(default_factory=time.monotonic)
    """When the damper's temperature was saved last, s of a monotonic clock."""
    _saving: threading.Thread | None = None
    _checked: bool = False

    def remaining_tests(self) -> list[PlannedTest]:
        """The incomplete tests, in their order."""
        complete = {entry.name for entry in self.journal.tests() if entry.state == "complete"}
        return [test for test in self.plan.tests if test.name not in complete]

    def restore_temperature(self) -> None:
        """Begin with the damper as warm as the journal's last host left it; :class:`InputError` where it has to cool first."""
        rig, limit = self.rig, self.rig.settings.limits.temperature
        self.journal.event_metadata = self._temperature
        if rig.damper_persists:
            with suppress(ValueError):  # there is none, or one that another program has written
                names = (TEMPERATURE, TEMPERATURE_TIME, TEMPERATURE_UPTIME)
                saved = SavedTemperature.parse(*map(self.journal.get_metadata, names))
                rig.warmth.estimate = max(rig.warmth.estimate, saved.cooled(rig.settings))
        if rig.warmth.hottest >= limit:
            raise InputError(
                f"the damper is at {rig.warmth.hottest:.0f} degC as estimated, and limits.temperature = {limit:g} degC; "
                "let it cool, and run the campaign again: it goes on"
            )

    def _temperature(self) -> dict[str, str]:
        """The damper's temperature with its time, for the journal."""
        if not self.rig.damper_persists:
            return {}
        hottest = f"{self.rig.warmth.hottest:.3f}"
        return {TEMPERATURE: hottest, TEMPERATURE_TIME: now(), TEMPERATURE_UPTIME: machine_uptime()}

    def perform(self) -> None:
        self._end_by_protocol(lambda work: work())
        left = self.remaining_tests()
        self.groups = groups_of(self.rig.settings, self.plan.campaign, datetime.now().astimezone())
        check_disk(self.folder, self.rig, left, self.plan.campaign, self.groups)
        self.journal.note(
            "armed", f"{len(left)} of {len(self.plan.tests)} tests to run; {self.rig.identity}; {self.rig.origin.kind}"
        )
        try:
            while left:  # a test that was skipped has cut the coil: the rig is armed again for the next one
                with suppress(Skipped):
                    self._perform_armed(left)
                left.extend(self._take_repeats())
        except EndedByProtocol as end:
            with _noting_trouble(end):
                self.journal.note("ended", str(end))
            raise
        except BaseException as problem:
            with _noting_trouble(problem):
                self.journal.note("ended early", reason(problem)["reason"])
            raise
        if missing := [test.name for test in self.remaining_tests()]:
            self.journal.note("ended", f"{len(missing)} of {len(self.plan.tests)} tests skipped")
            raise Stopped(
                f"skipped by the operator: {_name_first(missing)}; run the campaign again to record what is missing"
            )
        self.journal.note("complete", f"{len(self.plan.tests)} tests")

    def _perform_armed(self, left: list[PlannedTest]) -> None:
        """Perform what is in ``left``, and take each test out of it as it begins."""
        armed: list[ArmedRig] = []
        try:
            with self.rig.armed() as table:
                armed.append(table)
                self.control.abort_now = table.abort
                table.check = self.control.check
                self.control.check()
                self._prepare(table)
                first = True
                while left:
                    self._rest_between(table, left, first)
                    first = False
                    test = left.pop(0)
                    if self.control.skips(test.name):
                        self.journal.note("skipped", "by the operator", test.name)
                    else:
                        self._record_test(table, test, len(left) + 1)
                        if left:
                            self._end_by_protocol(table.meanwhile)
                    left.extend(self._take_repeats())
        finally:
            self.control.abort_now = None
            for table in armed:
                self._keep_passes(table)

    def _end_by_protocol(self, do: Callable[[Callable[[], object]], object]) -> None:
        """Raise `EndedByProtocol` where the records of the complete tests end the protocol; ``do`` does the slow work of it."""
        if not hasattr(protocol := self.plan.campaign.protocol, "ends"):
            return
        complete = [entry for entry in self.journal.tests() if entry.state == "complete"]
        readers = [partial(read_record, file_of(self.folder, entry.name, entry.attempt)) for entry in complete]
        found: list[str] = []
        if readers:
            do(lambda: found.append(protocol.ends(readers)))
        if any(found):
            raise EndedByProtocol(f"the protocol ends here: {found[0]}")

    def _take_repeats(self) -> list[PlannedTest]:
        """The tests that the operator wants to have once more."""
        names = self.control.repeats()
        for name in names:
            self.journal.repeat(name)
        return [test for name in names for test in self.plan.tests if test.name == name]

    def _prepare(self, table: ArmedRig) -> None:
        if table.homed:
            self._report_phase("verifying the index")
            if not table.pass_index():
                self.journal.note("index moved", "since the table was homed; it is homed again")
                warnings.warn(
                    "the encoder's index was not where homing had put it, so counts were lost; the table is homed again",
                    DampyrWarning,
                    stacklevel=5,
                )
        if not table.homed:
            self._report_phase("homing")
            table.home()
            self.journal.note("homed")
        if self.plan.preliminary is not None and not self._checked:
            self._report_phase("preliminary check")
            table.go(float(self.plan.preliminary.displacement[0]))
            self.journal.note("checked", preliminary_check(table, self.plan.preliminary, self.thresholds))
            self._checked = True
        table.specimen = self.groups.get("specimen", "")
        table.verify()
        self._compare_with_earlier_runs(table)

    def _compare_with_earlier_runs(self, table: ArmedRig) -> None:
        """Say at once where the first slow pass is not what it was in earlier runs with the specimen; the records do, too."""
        rig, first = self.rig.settings, table.passes[0]
        table.earlier = pass_to_compare(self.kept, first, rig, self.thresholds)
        compared = None if table.earlier is None else (table.earlier, first)
        self.provenance = self.provenance | {"cell_gain": describe_comparison(compared, rig, self.thresholds)}
        for mark in differs_from_earlier_runs(
            Evidence(compared=compared, shunts=tuple(table.shunts)), rig, self.thresholds
        ):
            self.journal.note("unlike earlier runs", mark.text)
            warnings.warn(f"{mark.text}; the records of this run say so", DampyrWarning, stacklevel=6)

    def _keep_passes(self, table: ArmedRig) -> None:
        """Keep the passes for the next run; where the first was not as before, what it was compared with stays."""
        rig, passes = self.rig.settings, table.passes
        if not passes or not passes[0].specimen:
            return
        earlier = pass_to_compare(self.kept, passes[0], rig, self.thresholds)
        if earlier is not None and differs_from_earlier_runs(
            Evidence(compared=(earlier, passes[0])), rig, self.thresholds
        ):
            return
        self.kept = with_run(self.kept, agreeing_passes(passes, rig, self.thresholds))
        self.rig.keep_passes(self.kept)

    def _rest_between(self, table: ArmedRig, left: list[PlannedTest], first: bool) -> None:
        """Rest between two tests, and while the campaign is paused."""
        self.control.check()
        if not first:
            self._report_phase("rest", left[0].name, len(left))
            table.rest(self.plan.campaign.header.rest_between)
        if self.control.paused:
            self.journal.note("paused")
            while self.control.paused:
                self.control.check()
                self._report_phase("paused", left[0].name, len(left))
                table.rest(0.1)
            self.journal.note("resumed")
        self.control.check()

    def _record_test(self, table: ArmedRig, test: PlannedTest, remaining: int) -> None:
        attempt, held = self.journal.begin(test.name, last_try(self.folder, test.name)), self.rig.clock_held
        if test.fitted:
            self.journal.note("fitted", test.fitted, test.name, attempt)
        try:
            self.control.under_way = test.name
            self._compare_clocks(table, test, remaining)
            learned = self._learn_drive(table, test, remaining, attempt) if test.test.learn else None
            judge, provenance, drive, before = None, self.provenance | self._counted(), test.drive, 0.0
            if learned is not None:
                judge, drive = PlayJudge(test.drive), learned.drive
                provenance, before = provenance | learned.provenance, TRIES * self.plan.try_time(test)
            path = file_of(self.folder, test.name, attempt)
            on_samples = self._report_samples(table, test, remaining, "testing", before)
            played = replace(test, drive=drive)
            marks = take(
                table, played, self.plan.campaign, path, attempt, self.groups, on_samples, provenance, judge,
                self.thresholds,
            )  # fmt: skip
        except BaseException as problem:
            outcome = reason(problem)
            with _noting_trouble(problem):
                self.journal.end(
                    test.name, "failed" if outcome["exit_status"] == "failed" else "stopped", outcome["reason"]
                )
            raise
        finally:
            self.control.under_way = ""
            self.control.skips(test.name)
            if (held := self.rig.clock_held - held) > 0.0:
                with suppress(FileError):
                    self.journal.note("clock held back", f"{held:.3f} s: this machine was too busy", test.name, attempt)
        if judge is not None and learned is not None:
            achieved = "not known" if judge.result is None else percent(judge.result.error)
            marks = (*marks, f"{achieved} off its wanted path, with a learned drive (tries: {learned.words})")
        self.journal.end(test.name, "complete", "; ".join(marks))

    def _counted(self) -> dict[str, str]:
        """What the protocol has a record say of the tests that are complete before it."""
        if not hasattr(protocol := self.plan.campaign.protocol, "counted"):
            return {}
        counted = protocol.counted(sum(entry.state == "complete" for entry in self.journal.tests()))
        return dict(counted)

    def _compare_clocks(self, table: ArmedRig, test: PlannedTest, remaining: int) -> None:
        """Wait until the Uno's clock is known against the board's, where the test's drive is learned or computed on the way."""
        if not (test.test.learn or getattr(test.step, "closed_loop", False)) or table.loop.clock_ratio.known:
            return
        self._report_phase("comparing the clocks", test.name, remaining)
        table.compare_clocks()
        self.journal.note("clocks compared", str(table.loop.clock_ratio), test.name)

    def _learn_drive(self, table: ArmedRig, test: PlannedTest, remaining: int, attempt: int) -> Learned:
        """Learn a test's drive, try by try."""

        def play(count: int, error: float | None) -> OnSamples:
            phase = f"learning, try {count} of {TRIES}" + ("" if error is None else f", {percent(error)} so far:")
            return self._report_samples(table, test, remaining, phase, (count - 1) * self.plan.try_time(test))

        return DriveLearning(
            table,
            self.plan,
            test,
            self.folder,
            attempt,
            self.journal,
            self.groups,
            self.provenance,
            play,
            self.thresholds,
        ).learn()

    def _report_samples(
        self, table: ArmedRig, test: PlannedTest, remaining: int, phase: str, before: float
    ) -> OnSamples:
        """What reports the samples of one play of a test; ``before`` s of what is planned for the test are over."""
        watch, rate = Watch(test, self.rig.settings.board.rate), self.rig.settings.board.rate
        total = len(self.plan.tests)
        first: int | None = None

        def report(samples: Samples) -> None:
            nonlocal first
            watch.take(samples)
            first = samples.first if first is None else first
            elapsed = (samples.first + samples.n - first) / rate
            # The temperature is saved beside the rig's settings too, in a thread: a disk that hesitates holds nothing up.
            if time.monotonic() - self._saved >= SAVE_EVERY and not (self._saving and self._saving.is_alive()):
                self._saved = time.monotonic()
                self._saving = threading.Thread(target=self.rig.save_temperature, name="temperature", daemon=True)
                self._saving.start()
            fraction, left = elapsed / max(test.duration, 1e-9), time_left(self.plan, remaining, before + elapsed)
            self.progress(
                Progress(
                    max(0, total - remaining), total, test.name, phase, min(1.0, fraction), max(0.0, left), watch.cycles,
                    watch.planned, float(samples.force[-1]), watch.stroke, table.temperature, samples,
                    self.rig.settings.force_delay,
                )
            )  # fmt: skip

        return report

    def _report_phase(self, phase: str, name: str = "", remaining: int | None = None) -> None:
        count = len(self.remaining_tests()) if remaining is None else remaining
        left = time_left(self.plan, count)
        self.progress(Progress(max(0, len(self.plan.tests) - count), len(self.plan.tests), name, phase, time_left=left))
