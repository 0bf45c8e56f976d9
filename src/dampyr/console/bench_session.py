"""The bench: one session that owns one rig, for any number of pages.

Commands come from any thread. Each is refused at once with an :class:`~dampyr.errors.InputError` where the bench is in no state
for it or the page does not hold control, or done soon by the bench's own thread; `Bench.state` tells how it went. Abort alone
does not wait and asks nobody. Nothing here keeps the table safe that the rig's rings of safety do not keep safe without it: a
server that dies leaves the rig to the firmware's watchdog.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import Any

from dampyr.campaigns import Plan, RunControl, Stopped
from dampyr.console.bench_alarms import READINGS, AlarmLimit, Alarms, Reading
from dampyr.console.bench_campaigns import CampaignRuns
from dampyr.console.bench_connection import RigConnection
from dampyr.console.bench_events import EventLog
from dampyr.console.bench_state import BenchState, Phase, firmware_ring, interlock_ring
from dampyr.console.bench_thread import RigThread
from dampyr.console.clients import Clients
from dampyr.console.decimation import MinMaxBins
from dampyr.console.error_responses import without_places
from dampyr.console.guided import GuidedCalibration, Step
from dampyr.console.manual_motion import Cancelled, ManualMotions, Motion, check_coil, coil_drive, play, sine_drive
from dampyr.console.page_words import in_page_words
from dampyr.console.preload import warm_up
from dampyr.console.rigs import Opener, opened, rig_settings
from dampyr.errors import DampyrError, InputError, RigFault
from dampyr.rig import Rig
from dampyr.rig.firmware.protocol import State
from dampyr.rig.session import ArmedRig

GRACE = 4.0  # s that an armed rig waits for a page that is loaded anew
FOLDER = "bench"
"""Of the data folder: the log of events and the alarm limits."""


class Bench:
    """One rig and who works with it; ``data`` is the folder of campaigns, rigs and records."""

    def __init__(self, data: Path, opener: Opener = opened, clock: Callable[[], float] = time.monotonic) -> None:
        self.data, self.clients = data, Clients(clock)
        self.strips: MinMaxBins | None = None
        """What is drawn of the rig; None before the first one."""
        self._opener, self._clock, self._born = opener, clock, clock()
        self._lock = threading.RLock()
        self.events, self._alarms = EventLog(data / FOLDER), Alarms(data / FOLDER)
        self.runs = CampaignRuns(data, self._lock, self.clients, self.events)
        self._phase: Phase = "disconnected"
        self._note, self._fault, self._tripped = "", False, ""
        self._connection: RigConnection | None = None
        self._table: ArmedRig | None = None
        self._calibration: GuidedCalibration | None = None
        self._motions, self._disarming = ManualMotions(self.clients, clock, self._leaving), threading.Event()
        self._thread = RigThread(self._look, self._tell, self._disconnect)

    @property
    def rig(self) -> Rig | None:
        """The rig that is connected."""
        return self._connection.rig if self._connection is not None else None

    def state(self) -> BenchState:
        """How the bench is."""
        with self._lock:
            connection, runs, calibration = self._connection, self.runs, self._calibration
            status, settings = (connection.status, connection.rig.settings) if connection else (None, None)
            armed = self._table is not None or runs.control.abort_now is not None
            rings = (
                firmware_ring(status),
                interlock_ring(settings, armed, self._tripped),
                runs.check_ring(self._phase == "campaign"),
            )
            return BenchState(
                self._phase, self._note, self._fault, armed, bool(status and status.homed),
                bool(status and status.state is State.JOGGING), connection.described() if connection else None,
                connection.live if connection else None,
                rings,
                calibration.guided if calibration else None, runs.run,
                self.clients.count, self.clients.titled(self.clients.holder), connection.live_age if connection else None,
                self._alarms.extremes, self._alarms.alarms, self._alarms.limits, tuple(order.queued for order in runs.waiting),
                runs.reference.comparison if runs.reference else None, self.events.count, self.events.trouble,
            )  # fmt: skip

    # Commands, from any thread.

    def take_control(self, client: str) -> None:
        """Take control, from whoever has it; what they moved stops."""
        before = self.clients.holder
        whose = self.clients.who(before)
        self.clients.take(client)
        if client != before:
            self._event(client, f"took control{f' from {whose}' if whose else ''}")

    def connect(self, client: str, rig: str = "", simulate: bool = True) -> None:
        """Connect to a rig of the data folder, the original one without a name."""
        rig_settings(self.data, rig)
        words = f"connects {rig or 'the original rig'}{', simulated' if simulate else ''}"
        self._accept(client, ("disconnected",), "connecting", words)
        self._thread.jobs.put(partial(self._connect, rig, simulate))

    def disconnect(self, client: str) -> None:
        """Let go of the rig; an armed one is disarmed first."""
        self._accept(client, ("idle", "armed"), "disconnecting", "disconnects")
        self._disarming.set()
        self._thread.jobs.put(self._disconnect)

    def arm(self, client: str) -> None:
        """Let energy in."""
        self._accept(client, ("idle",), "arming", "arms")
        self._thread.jobs.put(self._arm)

    def disarm(self, client: str) -> None:
        """Bring the table to rest and let no energy in."""
        self._accept(client, ("armed", "homing", "measuring", "moving"), "disarming", "disarms")
        self._disarming.set()

    def home(self, client: str, here: bool = False) -> None:
        """Look for the index mark, or take the place where the table stands for the middle."""
        words = "sets the centre where the table stands" if here else "homes by the index"
        self._move(client, words, lambda table: table.home(here), "homing")

    def jog(self, client: str, speed: float) -> None:
        """Move at ``speed`` [m/s] while this is called again and again, every 0.1 s or so; 0 stops."""
        self._motions.jogging.ask(client, speed, self._armed_table(client))

    def go(self, client: str, position: float) -> None:
        """Move slowly to ``position`` [m] from the middle."""
        self._armed_table(client).check_place(position, "position")
        self._move(client, f"goes to {position * 1e3:g} mm", lambda table: table.go(position))

    def sine(self, client: str, amplitude: float, frequency: float, voltage: float, cycles: int) -> None:
        """Move as a sine of ``amplitude`` [m], ``frequency`` [Hz] and ``voltage`` [V], without recording."""
        self._armed_table(client).check_homed()
        rig = self._connected_rig()
        drive = sine_drive(rig.settings, rig.folder, amplitude, frequency, voltage, cycles)
        words = f"moves as a sine, {amplitude * 1e3:g} mm, {frequency:g} Hz, {voltage:g} V, {cycles} cycles"
        self._move(client, words, lambda table: play(table, drive))

    def energise(self, client: str, voltage: float, seconds: float) -> None:
        """Put ``voltage`` [V] on the coil for ``seconds``, with the table at rest."""
        self._armed_table(client)
        check_coil(self._connected_rig().settings, voltage, seconds)
        words = f"puts {voltage:g} V on the coil for {seconds:g} s"
        self._move(client, words, lambda table: play(table, coil_drive(table, voltage, seconds)))

    def zero(self, client: str) -> None:
        """Take the mean signal of a second for no force."""
        self._move(client, "", lambda table: self._say(f"zero force is {table.zero_force():.5f} V now"), "measuring")

    def halt(self, client: str) -> None:
        """End a motion by hand, or the coil's voltage, and stay armed."""
        self._accept(client, ("armed", "moving", "homing"))
        self._motions.halted.set()

    def reset_extremes(self, client: str) -> None:
        """Let the least and the greatest readings begin anew."""
        self.clients.require(client)
        self._alarms.reset_extremes()

    def set_alarm_limit(self, client: str, reading: Reading, low: float | None, high: float | None) -> None:
        """Set or change the alarm limit of a reading; without low and high it is removed."""
        self.clients.require(client)
        self._alarms.set_limit(AlarmLimit(reading, low, high))
        self._event(client, f"sets the alarm limits of {READINGS[reading][0]}")

    def acknowledge(self, client: str, number: int | None = None) -> None:
        """Acknowledge an alarm, or all of them."""
        self.clients.require(client)
        if self._alarms.acknowledge(self.clients.name(client), number):
            self._event(client, "acknowledges " + ("all alarms" if number is None else f"alarm {number}"))

    def calibrate(self, client: str) -> None:
        """Begin the guided steps, with the rig disarmed: nothing moves and the coil stays at 0 V."""
        self._accept(client, ("idle",))
        self._calibration = GuidedCalibration(self._connected_rig())

    def calibrate_step(self, client: str, step: Step, load: str = "") -> None:
        """Read the cell ``unloaded``; ``loaded`` with a force or a mass such as "20 kg"; ``shunted`` with a resistor."""
        calibration = self._begun_calibration()
        self._accept(client, ("idle",), "measuring")
        self._thread.jobs.put(partial(self._read_cell, calibration, step, load))

    def calibrate_end(self, client: str, keep: bool) -> None:
        """Save the result, next to the rig's file if it has one, or discard it."""
        self._accept(client, ("idle",))
        calibration = self._begun_calibration()
        if keep and (saved := calibration.keep()):
            self._say(saved)
        self._calibration = None

    def start(self, client: str, campaign: str, folder: str, **about: Any) -> None:
        """Run a campaign into a folder of ``runs``; where that holds a part of it already, the rest.

        ``about`` is what `CampaignRuns.order` takes. Raises :class:`~dampyr.errors.InputError` where the folder is complete, of
        another campaign, or in use.
        """
        order = self.runs.order(campaign, folder, **about)
        self._accept(client, ("idle", "armed"))
        campaign_plan = self.runs.planned(order, self._connected_rig(), f"folder = {folder!r}: ")
        with self._lock:
            self._accept(client, ("idle", "armed"), "campaign")
            self.clients.operate(client, campaign_plan.campaign.header.operator)
            order.who = self.clients.who(client)
            self.runs.begin(order, campaign_plan)
        self._disarming.set()
        self._event(client, f"starts {campaign} into {folder}")
        self._thread.jobs.put(partial(self._perform, campaign_plan))

    def enqueue(self, client: str, campaign: str, folder: str, **about: Any) -> None:
        """Run a campaign, as `start` does, after the one under way, where that is complete then; it is checked in its turn."""
        order = self.runs.order(campaign, folder, **about)
        self.clients.require(client)
        self.runs.enqueue(client, order)
        self._event(client, f"queues {campaign} into {folder}")

    def dequeue(self, client: str, number: int) -> None:
        """Take a campaign out of the queue."""
        self.clients.require(client)
        self.runs.dequeue(number)

    def remove_run(self, client: str, folder: str, complete: int) -> None:
        """Remove an interrupted run with its records, of which the person was told that ``complete`` tests are whole.

        Raises :class:`~dampyr.errors.InputError` where it is not interrupted, waits in the queue, or holds another number.
        """
        self.clients.require(client)
        self.runs.remove(folder, complete)
        self._event(client, f"removes the interrupted run {folder}, {complete} of its tests complete")

    def skip(self, client: str, test: str) -> None:
        """Leave out a test of the campaign that runs; the one under way is ended in order and stays incomplete."""
        self._accept(client, ("campaign",), words=f"skips {test}")
        self.runs.control.skip(test)

    def repeat(self, client: str, test: str) -> None:
        """Record a test of the campaign that runs once more, after the tests that are left."""
        self._accept(client, ("campaign",), words=f"repeats {test}")
        self.runs.control.repeat(test)

    def pause(self, client: str, paused: bool = True) -> None:
        """Wait after the test under way, or go on."""
        self._accept(client, ("campaign",), words="pauses after the test under way" if paused else "resumes")
        (self.runs.control.pause if paused else self.runs.control.resume)()
        self.runs.change(paused=paused)

    def resume(self, client: str) -> None:
        """Go on."""
        self.pause(client, False)

    def stop(self, client: str) -> None:
        """End the campaign in order; it can be run on."""
        self._accept(client, ("campaign",), words="stops the campaign")
        self.runs.control.stop()

    def abort(self, who: str = "") -> None:
        """Brake the table and cut the coil, now; from any thread, by anyone. When this returns the rig has done it."""
        why = f"by {who or 'the operator'}"
        control = self.runs.abort(why)  # first: a rig that is being armed is looked at after this
        self._motions.jogging.forget()
        table, rig = self._table, self.rig
        if table is not None:
            table.abort(why)
        elif rig is not None and control.abort_now is None:
            with suppress(RigFault):  # a rig that does not answer has its watchdog
                rig.uno.abort()
        self.events.add(who or "the operator", "aborts")

    def close(self) -> None:
        """Stop, disarm and let go of the rig, in order."""
        self._thread.closing.set()
        self.runs.control.stop()
        self._thread.close()

    def _accept(self, client: str, phases: tuple[Phase, ...], then: Phase | None = None, words: str = "") -> None:
        """Begin the phase ``then``, where ``client`` holds control and the bench is in one of ``phases``; note it."""
        with self._lock:
            self.clients.require(client)
            if self._phase not in phases:
                raise InputError(f"the bench is {self._phase}; for this it has to be {' or '.join(phases)}")
            self._phase = then or self._phase
            if then in ("arming", "campaign"):  # what ended the last thing is past
                self.runs.control, self._note, self._fault = RunControl(), "", False
        if words:  # without the lock: a disk that hesitates holds nothing up
            self._event(client, words)

    def _move(self, client: str, words: str, motion: Motion, phase: Phase = "moving") -> None:
        """Do ``motion`` with the armed table, for as long as ``client`` holds control."""
        connection = self._connection
        if phase != "homing" and connection is not None and connection.status.state is not State.ARMED:
            repair = "measure when it is" if phase == "measuring" else "wait until it is"
            raise InputError(f"the table is not at rest; {repair}")
        with self._lock:
            self._accept(client, ("armed",), phase)
            self._motions.ask(client, motion)
        if words:
            self._event(client, words)

    def _armed_table(self, client: str) -> ArmedRig:
        self._accept(client, ("armed",))
        table = self._table
        if table is None:
            raise InputError("the bench is about to disarm; arm it again")
        return table

    def _begun_calibration(self) -> GuidedCalibration:
        if self._calibration is None:
            raise InputError("no calibration is under way; begin one")
        return self._calibration

    def _connected_rig(self) -> Rig:
        rig = self.rig
        if rig is None:
            raise InputError("no rig is connected; connect one first")
        return rig

    def _event(self, client: str, what: str) -> None:
        self.events.add(self.clients.who(client) or "a page", what)

    # Jobs, by the thread that owns the rig.

    def _connect(self, name: str, simulate: bool) -> None:
        """Open a rig and see who answers."""
        try:
            warm_up()
            with ExitStack() as failing:
                rig = failing.enter_context(self._opener(self.data, name, simulate))
                connection = RigConnection(rig, simulate, self._alarms, self.events, self._clock, self._born)
                failing.pop_all()
        except Exception:
            self._enter("disconnected")
            raise
        rig.on_energy.append(self.runs.note_energy)
        self._connection, self.strips, self._tripped = connection, connection.strips, ""
        self._enter("idle")
        self._say("connected")

    def _disconnect(self) -> None:
        """Let go of the rig."""
        rig, self._connection, self._calibration = self.rig, None, None
        try:
            if rig is not None:
                rig.close()
        finally:
            self._enter("disconnected")

    def _arm(self) -> None:
        """Stay armed, and do what is asked for, until there is a reason to leave."""
        rig = self._ready_rig()
        try:
            with rig.armed() as table:
                table.check, self._table = self._motions.check, table
                if self.runs.control.aborted:
                    table.abort()
                self._enter("armed")
                while not self._leaving():
                    self._step(table)
        except Exception as problem:  # told before the bench is idle again
            self._tell(problem)
        finally:
            self._table = None
            self._left("campaign", "disconnecting")

    def _step(self, table: ArmedRig) -> None:
        """One motion if one is asked for, else one block."""
        try:
            if not self._motions.step(table):
                self.clients.silent()
                if self.clients.alone > GRACE:
                    self._say("disarmed: no page is open any more")
                    self._enter("disarming", unless=("disconnecting", "campaign"))
                    self._disarming.set()
                return
        except (Cancelled, InputError) as problem:
            table.ask_uno(table.rig.uno.stop)
            self._tell(problem)
        self._enter("armed", unless=("disarming", "disconnecting", "campaign"))

    def _leaving(self) -> bool:
        return self._disarming.is_set() or self._thread.closing.is_set()

    def _read_cell(self, calibration: GuidedCalibration, step: Step, load: str) -> None:
        """A guided step of the calibration."""
        try:
            calibration.read(step, load)
            self._say("")
        finally:
            self._enter("idle")

    def _perform(self, campaign_plan: Plan) -> None:
        """Run a campaign to its end, whatever the end is; then the next one of the queue, where it was complete."""
        following = None
        try:
            self.runs.perform(campaign_plan, self._ready_rig)
            if not self._thread.closing.is_set():
                following = self.runs.begin_next(self._connected_rig())
        except Exception as problem:  # told before the bench is idle again
            self._tell(problem)
        if following is not None:
            self._thread.jobs.put(partial(self._perform, following))
        else:
            self._left("disconnected")

    def _ready_rig(self) -> Rig:
        """The rig, for something that arms it."""
        self._disarming.clear()
        self._motions.forget()
        self._tripped, self._calibration = "", None
        self._say("")
        return self._connected_rig()

    def _left(self, *phases: Phase) -> None:
        """See how the rig was left, and be idle unless in one of ``phases``."""
        if self._connection is not None:
            with suppress(RigFault):  # one that does not answer is told of by the next look
                self._connection.look()
        self._enter("idle", unless=phases)

    def _look(self) -> None:
        """See how a rig is that is not armed, and show what it reads to who looks."""
        self.clients.silent()
        if (connection := self._connection) is not None:
            try:
                connection.look()
            except RigFault:
                self._disconnect()
                raise
            connection.monitor(self._turns_away)

    def _turns_away(self) -> bool:
        self.clients.silent()
        return self._thread.wanted or not self.clients.count

    def _enter(self, phase: Phase, unless: tuple[Phase, ...] = ()) -> None:
        with self._lock:
            if self._phase not in unless:
                self._phase = phase

    def _say(self, note: str, fault: bool = False) -> None:
        with self._lock:
            self._note, self._fault = note, fault

    def _tell(self, problem: Exception) -> None:
        if isinstance(problem, RigFault) and problem.ring == "interlock":
            self._tripped = str(problem)
        if isinstance(problem, RigFault) and problem.ring != "operator":  # who aborts knows of it, and the log has it
            self.events.add("rig", str(problem))
            self._alarms.raise_alarm(str(problem))
        words = in_page_words(without_places(str(problem), self.data))
        if not isinstance(problem, DampyrError):
            words = f"an error of dampyr: {type(problem).__name__}: {words}"
        self._say(words, fault=not isinstance(problem, Cancelled | Stopped))
