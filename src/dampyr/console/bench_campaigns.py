"""Campaigns at the bench: the one that runs or ran last, with its reference and its report, and those that wait for it."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from pathlib import Path

from dampyr.campaigns import Plan, RunControl, perform, plan, read
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.journal import NAME as JOURNAL
from dampyr.campaigns.planned_tests import PlannedTest
from dampyr.campaigns.run_control import Progress, exit_status
from dampyr.campaigns.run_folders import folder_state, run_folder
from dampyr.console import safe_paths
from dampyr.console.bench_events import EventLog
from dampyr.console.bench_state import CampaignRun, Queued, Ring, check_ring
from dampyr.console.clients import Clients
from dampyr.console.grid import FOLDER as CAMPAIGNS
from dampyr.console.page_words import in_page_words
from dampyr.console.run_reference import RunReference
from dampyr.console.run_report import RunReport
from dampyr.errors import InputError
from dampyr.rig import Rig

RUNS = "runs"
MAX_QUEUE = 50  # campaigns that may wait
ADVANCING = ("phase", "done", "fraction", "time_left", "cycles", "planned_cycles", "stroke")
"""What a page sees of the progress of a run."""


@dataclass
class CampaignOrder:
    """A campaign that is to be run: ``path`` of its file, ``folder`` of its records, and ``who`` asked for it."""

    queued: Queued
    path: Path
    folder: Path
    reference: RunReference | None
    who: str = ""


def target_words(test: PlannedTest) -> str:
    """What a test is to do, and its peaks, for a person."""
    peaks = f"{1e3 * test.peak_position:.3g} mm, {1e3 * test.peak_speed:.3g} mm/s, {test.peak_voltage:.3g} V"
    return f"{test.words}; up to {peaks}; {test.duration:.0f} s"


def records_folder(data: Path, name: str) -> Path:
    """The folder of a run in a data folder, which need not exist."""
    folder = safe_paths.inside(data, f"{RUNS}/{name}")
    if folder.parent != data / RUNS:
        raise InputError(f"folder = {name!r} is not allowed; give a name without /")
    return folder


class CampaignRuns:
    """The campaigns of a bench with its ``data`` folder, its ``lock``, its pages and its ``events``."""

    def __init__(self, data: Path, lock: threading.RLock, clients: Clients, events: EventLog) -> None:
        self._data, self._lock, self._clients, self._events, self._numbers = data, lock, clients, events, count(1)
        self.waiting: list[CampaignOrder] = []
        self.run: CampaignRun | None = None
        self.reference: RunReference | None = None
        self.control, self._checked, self._refused = RunControl(), "", ""
        self._order: CampaignOrder | None = None
        self._targets: dict[str, str] = {}
        self._performing = False

    def order(
        self, campaign: str, folder: str, operator: str = "", specimen: str = "", note: str = "",
        reference: str = "", tolerance: float = 0.15,
    ) -> CampaignOrder:  # fmt: skip
        """What is to be run, of names in the data folder.

        ``operator``, ``specimen`` and ``note`` are as the campaign's file says where they are empty; ``reference`` is the
        folder of an earlier run, if any, with which cycles are compared within ``tolerance``, a ratio.
        """
        path = safe_paths.existing(self._data, f"{CAMPAIGNS}/{campaign}.toml")
        earlier = None
        if reference:
            place = safe_paths.existing(self._data, f"{RUNS}/{reference}/{JOURNAL}").parent
            if reference == folder:
                raise InputError(f"reference = {reference!r} is the folder of this run; choose an earlier run")
            earlier = RunReference(place, tolerance)
        about = operator.strip(), specimen.strip(), note.strip()
        place = records_folder(self._data, folder)
        return CampaignOrder(Queued(next(self._numbers), campaign, folder, *about), path, place, earlier)

    def planned(self, order: CampaignOrder, rig: Rig, about: str = "") -> Plan:
        """The plan of a campaign file with what is said about this run; refused as a whole.

        Where the folder is complete, of another campaign, or in use, the refusal begins with ``about``.
        """
        campaign, name = read(order.path), order.queued.name
        stated = {key: value for key in ("operator", "specimen", "note") if (value := getattr(order.queued, key))}
        campaign = replace(campaign, header=replace(campaign.header, **stated))
        campaign_plan = plan(campaign, rig.settings, specimen(rig.settings, rig.folder))
        with self._lock:
            self._refused = "; ".join(campaign_plan.refusals)
            self._checked = f"{name}: all of its {len(campaign_plan.tests)} tests passed"
        campaign_plan.require()
        state, words = folder_state(campaign_plan, order.folder)
        if state in ("complete", "foreign", "running"):
            raise InputError(about + words)
        return campaign_plan

    def begin(self, order: CampaignOrder, campaign_plan: Plan) -> None:
        """It is this campaign's turn."""
        with self._lock:
            self._order, self.reference, self._events.run_folder = order, order.reference, order.folder
            self._targets = {test.name: target_words(test) for test in campaign_plan.tests}
            header, queued = campaign_plan.campaign.header, order.queued
            self.run = CampaignRun(
                queued.name, queued.folder, len(campaign_plan.tests), time_left=campaign_plan.duration,
                operator=header.operator, specimen=header.specimen,
            )  # fmt: skip

    def enqueue(self, client: str, order: CampaignOrder) -> None:
        """Run a campaign after those before it, where they are complete then; it is checked when its turn comes."""
        with self._lock:
            if len(self.waiting) >= MAX_QUEUE:
                raise InputError(f"{MAX_QUEUE} campaigns wait already; remove one first")
            if order.folder in [waiting.folder for waiting in self.waiting]:
                raise InputError(f"folder = {order.folder.name!r} waits in the queue already; choose another folder")
            self._clients.operate(client, order.queued.operator)
            order.who = self._clients.who(client)
            self.waiting.append(order)

    def dequeue(self, number: int) -> None:
        """Take a campaign out of the queue."""
        with self._lock:
            self.waiting = [waiting for waiting in self.waiting if waiting.queued.number != number]

    def remove(self, folder: str, complete: int) -> None:
        """Remove the folder of an interrupted run, in which ``complete`` tests are known to be complete."""
        records_folder(self._data, folder)
        place = safe_paths.existing(self._data, f"{RUNS}/{folder}/{JOURNAL}").parent
        with self._lock:
            if place in [waiting.folder for waiting in self.waiting]:
                raise InputError(f"folder = {folder!r} waits in the queue; take it out of the queue first")
            state = run_folder(place)
            if state.state != "interrupted":
                raise InputError(f"folder = {folder!r} is {state.state}; only an interrupted run can be removed here")
            if state.complete != complete:
                raise InputError(
                    f"{folder} has {state.complete} complete tests by now, and not {complete}; look at it again"
                )
            gone = place.rename(place.with_name(f".removed {folder}"))
            if self.run is not None and self.run.folder == folder:
                self.run = None
        shutil.rmtree(gone)  # without the lock: many records take their time

    def begin_next(self, rig: Rig) -> Plan | None:
        """Begin the next campaign of the queue; None where there is none, or the last one was stopped or aborted."""
        with self._lock:
            ended, self.control = self.control, RunControl()
            # looked at once another is there: an abort that comes now sees that, and aborts it too
            if ended.aborted or ended.stopped or not self.waiting:
                return None
            order = self.waiting.pop(0)
        queued = order.queued
        try:
            campaign_plan = self.planned(order, rig)
        except Exception as problem:
            raise InputError(f"{queued.name}, the next of the queue, was not begun: {problem}") from problem
        self.begin(order, campaign_plan)
        self._events.add(f"queue of {order.who}", f"starts {queued.name} into {queued.folder}")
        return campaign_plan

    def check_ring(self, runs: bool) -> Ring:
        """The check of campaigns before they move, as a safety layer; ``runs``: one is under way."""
        return check_ring(self._checked, self._refused, runs)

    def targets(self, folder: str) -> dict[str, str]:
        """What each test of the run under way, or the last one, is to do, by its name; empty for another folder."""
        with self._lock:
            return self._targets if self.run is not None and self.run.folder == folder else {}

    def abort(self, why: str) -> RunControl:
        """Abort what runs, and what begins in this moment."""
        while True:
            control = self.control
            control.abort(why)
            if control is self.control:
                return control

    def perform(self, campaign_plan: Plan, ready: Callable[[], Rig]) -> None:
        """Run the campaign whose turn it is to its end, which is told, whatever it is; ``ready`` gives the rig."""
        order = self._order
        assert order is not None
        try:
            rig, self._performing = ready(), True
            self.control.check()
            perform(campaign_plan, rig, order.folder, self._progress, self.control)
            self._events.add("rig", "campaign complete")
            self.change(outcome="complete", fraction=1.0, done=len(campaign_plan.tests), time_left=0.0)
        except Exception as problem:
            outcome, why = exit_status(problem), in_page_words(str(problem)) or type(problem).__name__
            self._events.add("rig", f"campaign {why}" if why.startswith(outcome) else f"campaign {outcome}: {why}")
            self.change(outcome=outcome, reason=why)
            raise
        finally:
            self._performing, self._events.run_folder = False, None
        if order.reference is not None:  # it takes a process of its own, and minutes
            self.change(report_state="writing")
            write = partial(self._write_report, order, order.reference.report(order.folder))
            threading.Thread(target=write, name="report", daemon=True).start()

    def note_energy(self, armed: bool) -> None:
        """Note that the rig was armed or disarmed, by hand or for the campaign."""
        about, order = "", self._order
        if order is not None and self._performing:
            about = f" for the campaign {order.queued.name}, started by {order.who or 'the operator'}"
        self._events.add("rig", f"armed{about}" if armed else "disarmed")

    def change(self, **changes: object) -> None:
        """The campaign has come farther."""
        with self._lock:
            if self.run is not None:
                self.run = replace(self.run, **changes)  # type: ignore[arg-type]

    def _progress(self, progress: Progress) -> None:
        self._clients.silent()  # a page that has vanished keeps no control
        if self.reference is not None:
            self.reference.take(progress)
        values = {name: getattr(progress, name) for name in ADVANCING}
        self.change(test=progress.name, paused=self.control.paused, **values)

    def _write_report(self, order: CampaignOrder, report: RunReport) -> None:
        why = report.write()
        with self._lock:
            if self._order is order:
                self.change(report="" if why else report.path.name, report_state=why)
