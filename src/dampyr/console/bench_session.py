"""The bench: one session that owns one rig, for any number of pages.

Commands come from any thread. Each is refused at once with an :class:`~dampyr.errors.InputError` where the bench is in no state
for it or the page does not hold control, or done soon by the bench's own thread; `Bench.state` tells how it went. Abort alone
does not wait and asks nobody. Nothing here keeps the table safe that the rig's rings of safety do not keep safe without it: a
server that dies leaves the rig to the firmware's watchdog.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from pathlib import Path

from dampyr.campaigns import Plan, plan, read
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.run_folders import folder_state
from dampyr.console.bench_alarms import READINGS, AlarmLimit
from dampyr.console.bench_events import BenchEvent
from dampyr.console.bench_reference import ReferenceLoop
from dampyr.console.bench_state import (
    BenchState,
    ChartLimits,
    ConnectedRig,
    Phase,
    Queued,
    check_ring,
    firmware_ring,
    interlock_ring,
    new_run,
)
from dampyr.console.bench_thread import BenchThread, Prepared
from dampyr.console.clients import Clients
from dampyr.console.decimation import MinMaxBins
from dampyr.console.guided import Guided, Step
from dampyr.console.manual_motion import check_coil, coil_drive, play, sine_drive
from dampyr.console.rigs import Opener, opened
from dampyr.console.run_reference import RunReference
from dampyr.errors import InputError, RigFault
from dampyr.rig import Rig
from dampyr.rig.firmware.protocol import State
from dampyr.rig.load_cell_calibration import Calibrating
from dampyr.rig.session import ArmedRig

READING = 1.0  # s of the load cell
MAX_QUEUE = 50  # campaigns that may wait
FOLDER = "bench"
"""Of the data folder: the log of events and the alarm limits."""


@dataclass(frozen=True)
class RunAbout:
    """What is said about a run when it is started; what is empty is as the campaign's file says."""

    operator: str = ""
    specimen: str = ""
    note: str = ""


class Bench:
    """One rig and who works with it; ``data`` is the folder of campaigns, rigs and records."""

    def __init__(self, data: Path, opener: Opener = opened, clock: Callable[[], float] = time.monotonic) -> None:
        self.data, self.clients, self._opener = data, Clients(clock), opener
        self._thread = BenchThread(self.clients, clock, data / FOLDER)
        self._clock, self._numbers = clock, count(1)
        self._simulated, self._checked, self._refused = True, "", ""

    @property
    def rig(self) -> Rig | None:
        """The rig that is connected."""
        return self._thread.rig

    @property
    def strips(self) -> MinMaxBins | None:
        """What is drawn of it; None before the first one."""
        return self._thread.strips

    @property
    def events(self) -> list[BenchEvent]:
        """Who did what, the latest first."""
        return self._thread.events.recent()

    @property
    def reference_loop(self) -> ReferenceLoop | None:
        """The reference of the test under way, for drawing."""
        reference = self._thread.reference
        return None if reference is None else reference.loop

    def take_control(self, client: str) -> None:
        """Take control, from whoever has it; what they moved stops."""
        before = self.clients.name(self.clients.holder)
        self.clients.take(client)
        taken = self.clients.name(client)
        if taken != before:
            self._event(client, f"took control{f' from {before}' if before else ''}")

    def connect(self, client: str, rig: str = "", simulate: bool = True) -> None:
        """Connect to a rig of the data folder, the original one without a name."""
        self._accept(client, ("disconnected",), "connecting")
        self._simulated = simulate
        self._event(client, f"connects {rig or 'the original rig'}{', simulated' if simulate else ''}")
        self._thread.jobs.put(lambda: self._thread.connect(lambda: self._opener(self.data, rig, simulate)))

    def disconnect(self, client: str) -> None:
        """Let go of the rig; an armed one is disarmed first."""
        self._accept(client, ("idle", "armed"), "disconnecting")
        self._event(client, "disconnects")
        self._thread.disarm_requested.set()
        self._thread.jobs.put(self._thread.disconnect)

    def arm(self, client: str) -> None:
        """Let energy in."""
        with self._thread.lock:
            self._accept(client, ("idle",), "arming")
            self._thread.expect()
        self._event(client, "arms")
        self._thread.jobs.put(self._thread.arm)

    def disarm(self, client: str) -> None:
        """Bring the table to rest and let no energy in."""
        self._accept(client, ("armed", "homing", "measuring", "moving"), "disarming")
        self._event(client, "disarms")
        self._thread.disarm_requested.set()

    def home(self, client: str, here: bool = False) -> None:
        """Look for the index mark, or take the place where the table stands for the middle."""
        self._accept(client, ("armed",), "homing")
        self._event(client, "sets the centre where the table stands" if here else "homes by the index")
        self._thread.jogging.forget()
        self._thread.move(client, lambda table: table.home(here))

    def jog(self, client: str, speed: float) -> None:
        """Move at ``speed`` [m/s] while this is called again and again, every 0.1 s or so; 0 stops."""
        self._thread.jogging.ask(client, speed, self._table(client))

    def go(self, client: str, position: float) -> None:
        """Move slowly to ``position`` [m] from the middle."""
        self._table(client).check_place(position, "position")
        self._move(client, f"goes to {position * 1e3:g} mm", lambda table: table.go(position))

    def sine(self, client: str, amplitude: float, frequency: float, voltage: float, cycles: int) -> None:
        """Move as a sine of ``amplitude`` [m], ``frequency`` [Hz] and ``voltage`` [V], without recording."""
        self._table(client).check_homed()
        rig = self._connected()
        drive = sine_drive(rig.settings, rig.folder, amplitude, frequency, voltage, cycles)
        words = f"moves as a sine, {amplitude * 1e3:g} mm, {frequency:g} Hz, {voltage:g} V, {cycles} cycles"
        self._move(client, words, lambda table: play(table, drive))

    def energise(self, client: str, voltage: float, seconds: float) -> None:
        """Put ``voltage`` [V] on the coil for ``seconds``, with the table at rest."""
        self._table(client)
        check_coil(self._connected().settings, voltage, seconds)
        words = f"puts {voltage:g} V on the coil for {seconds:g} s"
        self._move(client, words, lambda table: play(table, coil_drive(table, voltage, seconds)))

    def halt(self, client: str) -> None:
        """End a motion by hand, or the coil's voltage, and stay armed."""
        self._accept(client, ("armed", "moving", "homing"), None)
        self._thread.halted.set()

    def reset_extremes(self, client: str) -> None:
        """Let the least and the greatest readings begin anew."""
        self.clients.require(client)
        self._thread.alarms.reset_extremes()

    def set_alarm_limit(self, client: str, limit: AlarmLimit) -> None:
        """Set, change or remove the alarm limit of a reading."""
        self.clients.require(client)
        self._thread.alarms.set_limit(limit)
        self._event(client, f"sets the alarm limits of {READINGS[limit.reading][0]}")

    def acknowledge(self, client: str, number: int | None = None) -> None:
        """Acknowledge an alarm, or all of them."""
        self.clients.require(client)
        if self._thread.alarms.acknowledge(self.clients.name(client), number):
            self._event(client, "acknowledges " + ("all alarms" if number is None else f"alarm {number}"))

    def zero(self, client: str) -> None:
        """Take the mean signal of a second for no force."""
        self._measure(client, lambda table: self._thread.say(f"zero force is {table.zero_force():.5f} V now"))

    def calibrate(self, client: str) -> None:
        """Begin the guided steps, with the rig disarmed: nothing moves and the coil stays at 0 V."""
        self._accept(client, ("idle",), None)
        self._thread.steps, self._thread.guided = Calibrating(self._connected(), READING), Guided()

    def calibrate_step(self, client: str, step: Step, load: str = "") -> None:
        """Read the cell ``unloaded``; ``loaded`` with a force or a mass such as "20 kg"; ``shunted`` with a resistor."""
        steps = self._steps()
        read = {"unloaded": steps.zero, "loaded": lambda: steps.loaded(load), "shunted": lambda: steps.shunted(load)}
        self._accept(client, ("idle",), "measuring")
        self._thread.jobs.put(partial(self._thread.read, step, read[step]))

    def calibrate_end(self, client: str, keep: bool) -> None:
        """Save the result, next to the rig's file if it has one, or discard it."""
        self._accept(client, ("idle",), None)
        steps, rig = self._steps(), self._connected()
        if keep and rig.folder is not None:
            self._thread.say(f"saved: {steps.save(rig.folder).name}, next to the rig's file")
        elif keep:
            rig.use(steps.calibration)
        self._thread.steps, self._thread.guided = None, None

    def start(
        self,
        client: str,
        name: str,
        path: Path,
        folder: Path,
        about: RunAbout | None = None,
        reference: RunReference | None = None,
    ) -> None:
        """Run a campaign file into a folder; where the folder holds a part of it already, the rest.

        Raises :class:`~dampyr.errors.InputError` where the folder is complete, of another campaign, or in use.
        """
        self._accept(client, ("idle", "armed"), None)
        campaign_plan = self._planned(name, path, about or RunAbout())
        state, words = folder_state(campaign_plan, folder)
        if state in ("complete", "foreign", "running"):
            raise InputError(f"folder = {folder.name!r}: {words}")
        with self._thread.lock:
            self._accept(client, ("idle", "armed"), "campaign")
            self._thread.expect()
            self._thread.run = new_run(self._queued(name, folder, about or RunAbout()), campaign_plan)
            self._thread.run_folder = folder
            self.clients.operate(client, campaign_plan.campaign.header.operator)
            self._thread.started_by = self.clients.who(client)
        self._thread.disarm_requested.set()
        self._event(client, f"starts {name} into {folder.name}")
        self._thread.jobs.put(partial(self._thread.perform, campaign_plan, folder, reference))

    def enqueue(
        self, client: str, name: str, path: Path, folder: Path, about: RunAbout, reference: RunReference | None = None
    ) -> None:
        """Run a campaign after the one under way, where that is complete then; it is checked when its turn comes."""
        self.clients.require(client)
        with self._thread.lock:
            if len(self._thread.queue) >= MAX_QUEUE:
                raise InputError(f"{MAX_QUEUE} campaigns wait already; remove one first")
            if folder.name in [queued.folder for queued, _ in self._thread.queue]:
                raise InputError(f"folder = {folder.name!r} waits in the queue already; choose another folder")

            self.clients.operate(client, about.operator)
            who = self.clients.who(client)

            def prepare() -> Prepared:
                campaign_plan = self._planned(name, path, about)
                state, words = folder_state(campaign_plan, folder)
                if state in ("complete", "foreign", "running"):
                    raise InputError(words)
                return Prepared(campaign_plan, folder, reference, who)

            self._thread.queue.append((self._queued(name, folder, about), prepare))
        self._event(client, f"queues {name} into {folder.name}")

    def dequeue(self, client: str, number: int) -> None:
        """Take a campaign out of the queue."""
        self.clients.require(client)
        with self._thread.lock:
            self._thread.queue[:] = [waiting for waiting in self._thread.queue if waiting[0].number != number]

    def skip(self, client: str, test: str) -> None:
        """Leave out a test of the campaign that runs; the one under way is ended in order and stays incomplete."""
        self._accept(client, ("campaign",), None)
        self._thread.control.skip(test)
        self._event(client, f"skips {test}")

    def repeat(self, client: str, test: str) -> None:
        """Record a test of the campaign that runs once more, after the tests that are left."""
        self._accept(client, ("campaign",), None)
        self._thread.control.repeat(test)
        self._event(client, f"repeats {test}")

    def _planned(self, name: str, path: Path, about: RunAbout) -> Plan:
        """The plan of a campaign file with what is said about this run; refused as a whole."""
        rig, campaign = self._connected(), read(path)
        stated = {key: value for key, value in vars(about).items() if value}
        campaign_plan = plan(
            replace(campaign, header=replace(campaign.header, **stated)),
            rig.settings,
            specimen(rig.settings, rig.folder),
        )
        self._refused, self._checked = (
            "; ".join(campaign_plan.refusals),
            f"{name}: all of its {len(campaign_plan.tests)} tests passed",
        )
        campaign_plan.require()
        return campaign_plan

    def _queued(self, name: str, folder: Path, about: RunAbout) -> Queued:
        return Queued(next(self._numbers), name, folder.name, about.operator, about.specimen, about.note)

    def pause(self, client: str, paused: bool) -> None:
        """Wait after the test under way, or go on."""
        self._accept(client, ("campaign",), None)
        (self._thread.control.pause if paused else self._thread.control.resume)()
        self._event(client, "pauses after the test under way" if paused else "resumes")
        self._thread.progressed(paused=paused)

    def stop(self, client: str) -> None:
        """End the campaign in order; it can be run on."""
        self._accept(client, ("campaign",), None)
        self._event(client, "stops the campaign")
        self._thread.control.stop()

    def abort(self, who: str = "") -> None:
        """Brake the table and cut the coil, now; from any thread, by anyone. When this returns the rig has done it."""
        thread, why = self._thread, f"by {who or 'the operator'}"
        with thread.lock:
            thread.aborted.set()
            control, table, rig = thread.control, thread.table, thread.rig
        thread.jogging.forget()
        control.abort(why)
        if table is not None:
            table.abort(why)
        elif rig is not None and control.abort_now is None:
            with suppress(RigFault):  # a rig that does not answer has its watchdog
                rig.uno.abort()
        thread.note_event(who or "the operator", "aborts")

    def close(self) -> None:
        """Stop, disarm and let go of the rig, in order."""
        self._thread.close()

    def state(self) -> BenchState:
        """How the bench is."""
        thread = self._thread
        with thread.lock:
            status, rig = thread.status, thread.rig
            armed = thread.table is not None or thread.control.abort_now is not None
            rings = (
                firmware_ring(status),
                interlock_ring(rig.settings if rig else None, armed, thread.tripped),
                check_ring(self._checked, self._refused),
            )
            return BenchState(
                thread.phase, thread.note, thread.fault, armed, bool(status and status.homed),
                bool(status and status.state is State.JOGGING), self._connected_rig(),
                thread.live, rings, thread.guided, thread.run,
                self.clients.count, self.clients.name(self.clients.holder),
                round(self._clock() - thread.live_at, 1) if thread.live is not None else None,
                thread.alarms.extremes, thread.alarms.alarms, thread.alarms.limits,
                tuple(queued for queued, _ in thread.queue),
                thread.reference.comparison if thread.reference is not None else None,
                thread.events.count, thread.events.trouble,
            )  # fmt: skip

    def _connected_rig(self) -> ConnectedRig | None:
        rig, status = self._thread.rig, self._thread.status
        if rig is None or rig.calibration is None:
            return None
        cell, settings, limits = rig.calibration, rig.settings, rig.settings.limits
        return ConnectedRig(
            settings.name,
            self._simulated,
            self._thread.identity,
            rate=settings.board.rate,
            stroke=limits.stroke,
            scale=cell.scale,
            zero=cell.zero,
            calibrated=cell.how,
            jog_speed=self._thread.jogging.fastest(bool(status and status.homed)),
            specimen=settings.specimen.name,
            limits=ChartLimits(limits.force, settings.travel, limits.speed, limits.voltage, limits.temperature),
            notice=rig.origin.notice,
        )

    def _event(self, client: str, what: str) -> None:
        self._thread.note_event(self.clients.who(client) or "a page", what)

    def _move(self, client: str, words: str, motion: Callable[[ArmedRig], None]) -> None:
        """Begin a motion by hand, with the table at rest."""
        status = self._thread.status
        if status is not None and status.state is not State.ARMED:
            raise InputError("the table is not at rest; wait until it is")
        self._accept(client, ("armed",), "moving")
        self._event(client, words)
        self._thread.move(client, motion)

    def _accept(self, client: str, phases: tuple[Phase, ...], then: Phase | None) -> None:
        """Begin the phase ``then``, where ``client`` holds control and the bench is in one of ``phases``."""
        with self._thread.lock:
            self.clients.require(client)
            if self._thread.phase not in phases:
                raise InputError(f"the bench is {self._thread.phase}; for this it has to be {' or '.join(phases)}")
            self._thread.phase = then or self._thread.phase

    def _table(self, client: str) -> ArmedRig:
        self._accept(client, ("armed",), None)
        table = self._thread.table
        if table is None:
            raise InputError("the bench is about to disarm; arm it again")
        return table

    def _measure(self, client: str, what: Callable[[ArmedRig], None]) -> None:
        status = self._thread.status
        if status is not None and status.state is not State.ARMED:
            raise InputError("the table is not at rest; measure when it is")
        self._accept(client, ("armed",), "measuring")
        self._thread.move(client, what)

    def _steps(self) -> Calibrating:
        if self._thread.steps is None:
            raise InputError("no calibration is under way; begin one")
        return self._thread.steps

    def _connected(self) -> Rig:
        if self._thread.rig is None:
            raise InputError("no rig is connected; connect one first")
        return self._thread.rig
