"""The thread that owns the rig: all access to it happens here, one thing after another, except an abort."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from dampyr.campaigns import Plan, RunControl, Stopped, perform
from dampyr.campaigns.run_control import Progress, exit_status
from dampyr.console.bench_alarms import Alarms
from dampyr.console.bench_events import EventLog
from dampyr.console.bench_state import CampaignRun, Live, Phase, Queued, advanced, new_run
from dampyr.console.clients import Clients
from dampyr.console.decimation import MinMaxBins
from dampyr.console.error_responses import without_places
from dampyr.console.guided import Guided, Step
from dampyr.console.jogging import Jogging
from dampyr.console.page_words import in_page_words
from dampyr.console.preload import warm_up
from dampyr.console.run_reference import REPORT, RunReference
from dampyr.errors import DampyrError, InputError, RigFault
from dampyr.rig import Rig
from dampyr.rig.firmware.protocol import Status
from dampyr.rig.interlock import Samples
from dampyr.rig.load_cell_calibration import Calibrating
from dampyr.rig.session import ArmedRig

GRACE = 4.0  # s that an armed rig waits for a page that is loaded anew
POLL = 0.25  # s between two looks at an idle rig
AGAIN = 5.0  # s until a board that could not be read is tried again while the rig is disarmed


class Cancelled(DampyrError):
    """A motion was ended because whoever asked for it is gone, or asked for something else."""


class Prepared(NamedTuple):
    """A campaign of the queue that can begin: what is run into which folder, against which reference, and who queued it."""

    plan: Plan
    folder: Path
    reference: RunReference | None
    who: str


class BenchThread:
    """What is known of the rig, and the jobs that wait for it."""

    def __init__(self, clients: Clients, clock: Callable[[], float], folder: Path) -> None:
        self.clients, self.clock, self.born = clients, clock, clock()
        self.events, self.alarms, self._data = EventLog(folder), Alarms(folder), folder.parent
        self.lock = threading.RLock()
        self.phase: Phase = "disconnected"
        self.note, self.fault, self.tripped = "", False, ""
        self.rig: Rig | None = None
        self.table: ArmedRig | None = None
        self.identity = ""
        self.status: Status | None = None
        self.live: Live | None = None
        self.live_at = 0.0
        """When ``live`` was read, s of the clock."""
        self.strips: MinMaxBins | None = None
        self.guided: Guided | None = None
        self.steps: Calibrating | None = None
        self.run: CampaignRun | None = None
        self.run_folder: Path | None = None
        self.reference: RunReference | None = None
        self.halted = threading.Event()
        self.queue: list[tuple[Queued, Callable[[], Prepared]]] = []
        self.started_by = ""
        """Who started the campaign that runs."""
        self._doubted, self._performing = False, False
        self.control, self.jogging = RunControl(), Jogging(clock)
        self.disarm_requested, self.aborted, self.closing = threading.Event(), threading.Event(), threading.Event()
        self.jobs: queue.Queue[Callable[[], None]] = queue.Queue()
        self._motions: queue.Queue[tuple[str, Callable[[ArmedRig], None]]] = queue.Queue()
        self._mover, self._unread = "", 0.0
        self._thread = threading.Thread(target=self._work, name="bench", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop, disarm and let go of the rig, in order."""
        self.closing.set()
        self.jobs.put(lambda: None)  # an idle thread looks at once, and not at its next poll
        self.control.stop()
        self._thread.join(timeout=20.0)

    def say(self, note: str, fault: bool = False) -> None:
        """Something worth telling."""
        with self.lock:
            self.note, self.fault = note, fault

    def note_event(self, who: str, what: str) -> None:
        """Note an event; while a campaign runs its folder gets it too."""
        running = self.run is not None and self.run.outcome == "running"
        self.events.add(who, what, self.run_folder if running else None)

    def expect(self) -> None:
        """Something is about to begin: what ended the last thing is past."""
        with self.lock:
            self.aborted.clear()
            self.control, self.note, self.fault = RunControl(), "", False

    def enter(self, phase: Phase, unless: tuple[Phase, ...] = ()) -> None:
        """Another phase begins."""
        with self.lock:
            if self.phase not in unless:
                self.phase = phase

    def move(self, client: str, motion: Callable[[ArmedRig], None]) -> None:
        """Do ``motion`` with the armed table, for as long as ``client`` holds control."""
        self._motions.put((client, motion))

    def progressed(self, **changes: object) -> None:
        """The campaign has come farther."""
        with self.lock:
            if self.run is not None:
                self.run = replace(self.run, **changes)  # type: ignore[arg-type]

    # Jobs.

    def connect(self, opener: Callable[[], Rig]) -> None:
        """Open a rig and see who answers."""
        try:
            warm_up()
            rig = opener()
        except Exception:
            self.enter("disconnected")
            raise
        rig.watchers.append(self._seen)
        rig.on_energy.append(self._tell_energy)
        self.strips = MinMaxBins(rig.settings.board.rate, self.clock() - self.born)
        self.identity, _ = rig.identity, rig.origin  # asked of the instruments here, once
        self.rig, self.status = rig, rig.uno.heartbeat()
        self.tripped = ""
        self.enter("idle")
        self.say("connected")

    def disconnect(self) -> None:
        """Let go of the rig."""
        rig, self.rig, self.status, self.live, self.guided, self.steps = self.rig, None, None, None, None, None
        if rig is not None:
            rig.close()
        self.enter("disconnected")

    def arm(self) -> None:
        """Stay armed, and do what is asked for, until there is a reason to leave."""
        rig = self._begun()
        try:
            with rig.armed() as table:
                table.check, self.table = self._check, table
                if self.aborted.is_set():
                    table.abort()
                self.enter("armed")
                while not (self.disarm_requested.is_set() or self.closing.is_set()):
                    self._step(table)
        except Exception as problem:  # told before the bench is idle again
            self._tell(problem)
        finally:
            self.table = None
            while not self._motions.empty():
                self._motions.get_nowait()
            self._look(rig)
            self.enter("idle", unless=("campaign", "disconnecting"))

    def perform(self, campaign_plan: Plan, folder: Path, reference: RunReference | None = None) -> None:
        """Run a campaign to its end, whatever the end is; then the next one of the queue, where it was complete."""
        rig = self._begun()
        self.run_folder, self.reference = folder, reference
        self._performing = True
        complete = False
        try:
            self.control.check()
            perform(campaign_plan, rig, folder, self._progress, self.control)
            complete = True
            self.note_event("rig", "campaign complete")
            self.progressed(outcome="complete", fraction=1.0, done=len(campaign_plan.tests), time_left=0.0)
        except Exception as problem:
            outcome, why = exit_status(problem), str(problem) or type(problem).__name__
            self.note_event("rig", f"campaign {why}" if why.startswith(outcome) else f"campaign {outcome}: {why}")
            self.progressed(outcome=outcome, reason=why)
            self._tell(problem)
        finally:
            self._performing = False
            self._look(rig)
            if complete and reference is not None:
                self.progressed(report_state="writing")
                write = partial(self._write_report, folder, reference)  # it takes a process of its own, and minutes
                threading.Thread(target=write, name="report", daemon=True).start()
            if not (complete and self._begin_next()):
                self.enter("idle")

    def _begin_next(self) -> bool:
        """Begin the next campaign of the queue; whether there was one that can be run."""
        with self.lock:
            if not self.queue or self.closing.is_set():
                return False
            queued, prepare = self.queue.pop(0)
        try:
            campaign_plan, folder, reference, who = prepare()
        except Exception as problem:
            self._tell(InputError(f"{queued.name}, the next of the queue, was not begun: {problem}"))
            return False
        with self.lock:
            self.expect()
            self.run, self.run_folder, self.started_by = new_run(queued, campaign_plan), folder, who
        self.note_event(f"queue of {who}", f"starts {queued.name} into {queued.folder}")
        self.jobs.put(partial(self.perform, campaign_plan, folder, reference))
        return True

    def _write_report(self, folder: Path, reference: RunReference) -> None:
        why = reference.write_report(folder)
        with self.lock:
            if self.run is not None and self.run_folder == folder:
                self.run = replace(self.run, report="" if why else REPORT, report_state=why)

    def read(self, step: Step, read: Callable[[], float]) -> None:
        """A guided step of the calibration."""
        try:
            read()
            if self.steps is not None:
                self.guided = (self.guided or Guided()).after(step, self.steps)
            self.say("")
        finally:
            self.enter("idle")

    def _begun(self) -> Rig:
        assert self.rig is not None
        self.disarm_requested.clear()
        self.jogging.forget()
        self.tripped, self.guided, self.steps = "", None, None
        self.say("")
        return self.rig

    # The thread.

    def _work(self) -> None:
        while not self.closing.is_set():
            try:
                job = self.jobs.get(timeout=POLL)
            except queue.Empty:
                job = self._poll
            try:
                job()
            except Exception as problem:  # told on the page; the thread goes on, or nothing could be disarmed any more
                self._tell(problem)
        with suppress(RigFault):
            self.disconnect()

    def _poll(self) -> None:
        self.clients.silent()
        if self.rig is None:
            return
        try:
            self.status = self.rig.uno.heartbeat()
        except RigFault:
            self.disconnect()
            raise
        if self.rig.time_passes and self.clients.count and self._unread <= self.clock():
            self._monitor(self.rig)

    def _monitor(self, rig: Rig) -> None:
        """Show what a rig reads that is not armed, until there is something to do."""
        blocks = rig.monitor()
        try:
            for samples in blocks:
                self._seen(samples)
                self.clients.silent()
                if not self.jobs.empty() or self.closing.is_set() or not self.clients.count:
                    return
        except RigFault as problem:
            self._unread = self.clock() + AGAIN
            raise RigFault(f"nothing can be read while the rig is disarmed: {problem}", problem.ring) from None
        finally:
            blocks.close()

    def _look(self, rig: Rig) -> None:
        """See how the rig was left; one that does not answer is told of by the next poll."""
        with suppress(RigFault):
            self.status = rig.uno.heartbeat()

    def _step(self, table: ArmedRig) -> None:
        """One motion if one is asked for, else one block."""
        try:
            self._mover, motion = self._motions.get_nowait()
        except queue.Empty:
            next(table.loop.blocks())
            self.jogging.steer(table, self.clients.holder)
            self._look_after()
            return
        self.halted.clear()
        try:
            motion(table)
        except (Cancelled, InputError) as problem:
            table.ask_uno(table.rig.uno.stop)
            self._tell(problem)
        finally:
            self.enter("armed", unless=("disarming", "disconnecting", "campaign"))

    def _look_after(self) -> None:
        """Disarm a rig that nobody looks at."""
        self.clients.silent()
        if self.clients.alone > GRACE:
            self.say("disarmed: no page is open any more")
            self.enter("disarming")
            self.disarm_requested.set()

    def _check(self) -> None:
        """Whether what moves may go on."""
        self.clients.silent()
        if self.disarm_requested.is_set() or self.closing.is_set():
            raise Cancelled("ended: the rig is disarmed")
        if self.halted.is_set():
            raise Cancelled("ended by the operator")
        if self._mover != self.clients.holder:
            raise Cancelled("ended: the page that requested it no longer holds control")

    def _progress(self, progress: Progress) -> None:
        self.clients.silent()  # a page that has vanished keeps no control
        if self.reference is not None:
            self.reference.take(progress)
        self.progressed(**advanced(progress, self.control.paused))

    def _seen(self, samples: Samples) -> None:
        """A block, by the thread that reads them."""
        rig, strips = self.rig, self.strips
        if rig is None or strips is None:
            return
        warm = rig.warmth.temperature
        strips.take(samples, warm, self.clock() - self.born)
        for words in self.alarms.take(samples, warm, rig.settings.board.rate):
            # a disk that hesitates must not hold up the thread that reads
            threading.Thread(target=self.note_event, args=("alarm", words), name="alarm", daemon=True).start()
        if (doubt := rig.warmth.doubt) and not self._doubted:
            self.alarms.raise_alarm(doubt)
            threading.Thread(target=self.note_event, args=("alarm", doubt), name="alarm", daemon=True).start()
        self._doubted = bool(doubt)
        self.status, self.live_at = samples.status, self.clock()
        self.live = Live(float(samples.displacement[-1]), float(samples.force[-1]), float(samples.voltage[-1]), warm)

    def _tell_energy(self, armed: bool) -> None:
        """The rig was armed or disarmed, by hand or by the campaign."""
        run = self.run if self._performing else None
        about = "" if run is None else f" for the campaign {run.name}, started by {self.started_by or 'the operator'}"
        self.note_event("rig", f"armed{about}" if armed else "disarmed")

    def _tell(self, problem: Exception) -> None:
        if isinstance(problem, RigFault) and problem.ring == "interlock":
            self.tripped = str(problem)
        if isinstance(problem, RigFault) and problem.ring != "operator":  # who aborts knows of it, and the log has it
            self.note_event("rig", str(problem))
            self.alarms.raise_alarm(str(problem))
        expected = isinstance(problem, DampyrError)
        words = in_page_words(without_places(str(problem), self._data))
        if not expected:
            words = f"an error of dampyr: {type(problem).__name__}: {words}"
        self.say(words, fault=not isinstance(problem, Cancelled | Stopped))
