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
from functools import partial
from pathlib import Path

from dampyr.campaigns import plan, read, specimen
from dampyr.console.bench_state import BenchState, ConnectedRig, Phase, Run, check_ring, firmware_ring, interlock_ring
from dampyr.console.bench_thread import BenchThread
from dampyr.console.clients import Clients
from dampyr.console.decimation import MinMaxBins
from dampyr.console.guided import Guided, Step
from dampyr.console.rigs import Opener, opened
from dampyr.errors import InputError, RigFault
from dampyr.rig import Rig, Table
from dampyr.rig.firmware.protocol import State
from dampyr.rig.load_cell_calibration import Calibrating

READING = 1.0  # s of the load cell


class Bench:
    """One rig and who works with it; ``data`` is the folder of campaigns, rigs and records."""

    def __init__(self, data: Path, opener: Opener = opened, clock: Callable[[], float] = time.monotonic) -> None:
        self.data, self.clients, self._opener = data, Clients(clock), opener
        self._thread = BenchThread(self.clients, clock)
        self._simulated, self._checked, self._refused = True, "", ""

    @property
    def rig(self) -> Rig | None:
        """The rig that is connected."""
        return self._thread.rig

    @property
    def strips(self) -> MinMaxBins | None:
        """What is drawn of it; None before the first one."""
        return self._thread.strips

    def connect(self, client: str, rig: str = "", simulate: bool = True) -> None:
        """Connect to a rig of the data folder, the original one without a name."""
        self._accept(client, ("disconnected",), "connecting")
        self._simulated = simulate
        self._thread.jobs.put(lambda: self._thread.connect(lambda: self._opener(self.data, rig, simulate)))

    def disconnect(self, client: str) -> None:
        """Let go of the rig; an armed one is disarmed first."""
        self._accept(client, ("idle", "armed"), "disconnecting")
        self._thread.disarm_requested.set()
        self._thread.jobs.put(self._thread.disconnect)

    def arm(self, client: str) -> None:
        """Let energy in."""
        with self._thread.lock:
            self._accept(client, ("idle",), "arming")
            self._thread.expect()
        self._thread.jobs.put(self._thread.arm)

    def disarm(self, client: str) -> None:
        """Bring the table to rest and let no energy in."""
        self._accept(client, ("armed", "homing", "measuring"), "disarming")
        self._thread.disarm_requested.set()

    def home(self, client: str, here: bool = False) -> None:
        """Look for the index mark, or take the place where the table stands for the middle."""
        self._accept(client, ("armed",), "homing")
        self._thread.jogging.forget()
        self._thread.move(client, lambda table: table.home(here))

    def jog(self, client: str, speed: float) -> None:
        """Move at ``speed`` [m/s] while this is called again and again, every 0.1 s or so; 0 stops."""
        self._thread.jogging.ask(client, speed, self._table(client))

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

    def start(self, client: str, name: str, path: Path, folder: Path) -> None:
        """Run a campaign file into a folder; where the folder holds a part of it already, the rest."""
        self._accept(client, ("idle", "armed"), None)
        rig = self._connected()
        campaign_plan = plan(read(path), rig.settings, specimen(rig.settings, rig.folder))
        self._refused, self._checked = (
            "; ".join(campaign_plan.refusals),
            f"{name}: all of its {len(campaign_plan.tests)} tests passed",
        )
        campaign_plan.require()
        with self._thread.lock:
            self._accept(client, ("idle", "armed"), "campaign")
            self._thread.expect()
            self._thread.run = Run(name, folder.name, len(campaign_plan.tests), time_left=campaign_plan.duration)
        self._thread.disarm_requested.set()
        self._thread.jobs.put(partial(self._thread.perform, campaign_plan, folder))

    def pause(self, client: str, paused: bool) -> None:
        """Wait after the test under way, or go on."""
        self._accept(client, ("campaign",), None)
        (self._thread.control.pause if paused else self._thread.control.resume)()
        self._thread.progressed(paused=paused)

    def stop(self, client: str) -> None:
        """End the campaign in order; it can be run on."""
        self._accept(client, ("campaign",), None)
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
            )  # fmt: skip

    def _connected_rig(self) -> ConnectedRig | None:
        rig, status = self._thread.rig, self._thread.status
        if rig is None or rig.calibration is None:
            return None
        cell, settings = rig.calibration, rig.settings
        fastest = self._thread.jogging.fastest(bool(status and status.homed))
        values = (settings.board.rate, settings.limits.stroke, cell.scale, cell.zero, cell.how, fastest)
        return ConnectedRig(settings.name, self._simulated, self._thread.identity, *values)

    def _accept(self, client: str, phases: tuple[Phase, ...], then: Phase | None) -> None:
        """Begin the phase ``then``, where ``client`` holds control and the bench is in one of ``phases``."""
        with self._thread.lock:
            self.clients.require(client)
            if self._thread.phase not in phases:
                raise InputError(f"the bench is {self._thread.phase}; for this it has to be {' or '.join(phases)}")
            self._thread.phase = then or self._thread.phase

    def _table(self, client: str) -> Table:
        self._accept(client, ("armed",), None)
        table = self._thread.table
        if table is None:
            raise InputError("the bench is about to disarm; arm it again")
        return table

    def _measure(self, client: str, what: Callable[[Table], None]) -> None:
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
