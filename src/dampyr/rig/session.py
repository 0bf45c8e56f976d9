"""Session with a rig: it is energised only through `Rig.armed`, after which the coil is at 0 V and the table at rest."""

from __future__ import annotations

import math
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cached_property, partial
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, FileError, InputError, RigFault
from dampyr.origin import SIMULATED, Origin, of_board
from dampyr.rig.acquisition import Acquisition, fault_in_words
from dampyr.rig.calibration import Calibration, calibration_of, load_calibration
from dampyr.rig.cell_noise import least_noise
from dampyr.rig.damper_temperature import load_temperature, save_temperature
from dampyr.rig.drive import Drive
from dampyr.rig.firmware.control_core import SLOW
from dampyr.rig.firmware.protocol import Fault, State
from dampyr.rig.gc_control import disable_gc, freeze_objects
from dampyr.rig.instruments.catalogue import OUTPUT
from dampyr.rig.instruments.contract import Board, TableDrive, stated_origin
from dampyr.rig.interlock import Interlock, Samples
from dampyr.rig.loop import SETTLED, Loop
from dampyr.rig.player import Player
from dampyr.rig.settings import RigSettings
from dampyr.rig.shunt import READ, ShuntStep, step_of, switch_shunt
from dampyr.rig.shunt import SETTLED as SHUNT_SETTLED
from dampyr.rig.signal_deferral import deferred_signals
from dampyr.rig.slow_passes import GENTLE, SIDE, SlowPass, cell_of, load_passes, save_passes
from dampyr.rig.thermal_model import Warmth
from dampyr.rig.uno_clock import KNOWN, UnoClock
from dampyr.shown import Shown

Array = NDArray[np.float64]
ARRIVED = 5e-4  # m: from there on a drive's first step is one that the table follows
STANDING = 2e-4  # m by which a table that has arrived may be off
QUICK = 0.2  # s of work during which the board's buffer is enough
HOMING = 240.0  # s that the search for the index may take: to and fro over a stroke at 2 mm/s
COMPARING = 120  # s that the comparison of the clocks may take: with a latency of 1 to 16 ms it takes 20 to 30
BACK = 0.4  # s of a jog on the way back from outside of the limits, renewed before its 0.5 s are over
OVERSHOOT = (
    1e-4  # m before the ends of the travel, to which the table goes: it stops a few counts of 5 um beyond its place
)
PAST_INDEX = 2.5e-4  # m on both sides of the index between which it is passed
INDEX_GONE = (
    "the encoder's index was not passed where homing put it, so counts were lost or the scale has slipped; look at the "
    "encoder and its wires, and home the table again"
)
ZEROED = ", zeroed at rest"


def local_loop(rig: Rig) -> Acquisition:
    """The loop that reads a rig in this process."""
    assert rig.calibration is not None
    guard = Interlock(rig.settings, index=rig.index) if rig.interlocked else None
    return Acquisition(
        rig.settings,
        rig.uno,
        rig.board,
        rig.calibration,
        guard,
        rig.warmth,
        rig.threaded,
        rig.watchers,
        rig.clock if rig.threaded or rig.clocked_by_reads else None,
        rig.uno_clock,
    )


@dataclass(repr=False)
class Rig(Shown):
    """A rig that is connected and not armed; see `dampyr.rig.connect` and `dampyr.rig.simulated`.

    ``clocked_by_reads``: its time passes only while it is read, as that of a rig simulated in this process.
    ``clock``: the host's monotonic time [s], by which late readings are noticed; where ``clocked_by_reads`` that of the rig.
    ``make_loop`` makes the loop that reads it once it is armed.
    ``held``: s for which the clock of a simulated rig in real time was held back so far.
    ``damper_persists``: the damper is as warm as the last host left it; that of a simulated rig is a new one.
    ``simulated``: it is one that `dampyr.rig.simulated` has made.
    Each of ``watchers`` is called with every block of samples, by the thread that reads them: it has to be quick. Each of
    ``on_energy`` is called with True when the rig has been armed and with False when it has been disarmed.
    """

    settings: RigSettings
    uno: TableDrive
    board: Board
    threaded: bool = True
    calibration: Calibration | None = None
    interlocked: bool = True
    folder: Path | None = None
    clocked_by_reads: bool = False
    clock: Callable[[], float] = time.monotonic
    make_loop: Callable[[Rig], Loop] = local_loop
    on_close: list[Callable[[], None]] = field(default_factory=list)
    watchers: list[Callable[[Samples], None]] = field(default_factory=list)
    on_energy: list[Callable[[bool], None]] = field(default_factory=list)
    damper_persists: bool = True
    held: Callable[[], float] = lambda: 0.0
    simulated: bool = False
    warmth: Warmth = field(init=False)
    uno_clock: UnoClock = field(init=False, default_factory=UnoClock)
    """What is known of the Uno's clock, where this process reads the rig."""
    was_armed: bool = field(init=False, default=False)
    """Whether it has been armed since it was connected: before, nothing has moved."""
    index: dict[int, int] = field(init=False, default_factory=dict)
    """Where the encoder's index is passed; see `Interlock`. Empty: its next pass tells."""
    homed_by_hand: bool = field(init=False, default=False)
    """Whether this host homed it by hand: where its index is passed is not certain then until it has been."""
    _taken_over: bool = field(init=False, default=False)
    _energised: bool = field(init=False, default=False)
    """Whether those in ``on_energy`` know it as armed."""
    _read_until: float | None = field(init=False, default=None)
    """When it was last read, s of the clock."""
    _kept_passes: tuple[SlowPass, ...] = field(init=False, default=())

    def __post_init__(self) -> None:
        saved = load_calibration(self.folder) if self.folder else None
        self.calibration = self.calibration or saved or calibration_of(self.settings)
        self.settings = self.calibration.corrected(self.settings)
        self.warmth = Warmth(self.settings, self.settings.specimen.room)
        if self.damper_persists and self.folder and (warm := load_temperature(self.folder)):
            self.warmth.estimate = warm.cooled(self.settings)
        if self.threaded:
            self.on_close.append(disable_gc())

    @property
    def clock_held(self) -> float:
        """s for which the clock of a simulated rig in real time was held back since it was connected, as this machine was too
        busy for it; 0 for any other rig.
        """
        return self.held()

    @contextmanager
    def armed(self) -> Iterator[ArmedRig]:
        """Arm the rig: a `ArmedRig` that can be moved. On leaving: coil to 0 V, stop, rest, disarm, in this order.

        Signals that would end the process wait meanwhile: a second Ctrl-C does not cut the way out short.
        """
        if self.threaded:
            freeze_objects()
        self._cool_since_last_read()
        self._take_over()
        self.uno.configure(self.settings)
        table = ArmedRig(self)
        self.was_armed = True
        try:
            table.begin()
            self._announce_energy(True)
            yield table
        except BaseException as problem:
            _leave(table, problem)
            raise
        else:
            _leave(table, None)
        finally:
            self._read_until = self.clock()
            self._announce_energy(False)
            self.save_temperature()

    def _announce_energy(self, armed: bool) -> None:
        for listener in self.on_energy if armed or self._energised else ():
            listener(armed)
        self._energised = armed

    def save_temperature(self) -> None:
        """Save the damper's temperature for the next host, beside the ``rig.toml``; a failure is a warning."""
        if self.damper_persists and self.folder:
            try:
                save_temperature(self.folder, self.warmth.hottest)
            except FileError as problem:
                warnings.warn(f"the damper's temperature was not saved: {problem}", DampyrWarning, stacklevel=2)

    def kept_passes(self) -> tuple[SlowPass, ...]:
        """The latest slow passes with each specimen: those beside the ``rig.toml``, else those of this rig since it is
        connected.

        Raises :class:`~dampyr.errors.FileError` where the file is wrong.
        """
        if self.damper_persists and self.folder:
            return load_passes(self.folder)
        return self._kept_passes

    def keep_passes(self, kept: tuple[SlowPass, ...]) -> None:
        """Keep slow passes for the next run, beside the ``rig.toml`` where its damper is one; a failure is a warning."""
        self._kept_passes = kept
        if self.damper_persists and self.folder:
            try:
                save_passes(self.folder, kept)
            except FileError as problem:
                warnings.warn(f"the slow passes of this run were not kept: {problem}", DampyrWarning, stacklevel=2)

    def _cool_since_last_read(self) -> None:
        """Let the estimate cool for the time in which nothing was read; that of a rig whose time stands does not pass."""
        if self._read_until is not None and not self.clocked_by_reads:
            self.warmth.cool(max(0.0, self.clock() - self._read_until))

    def _take_over(self) -> None:
        """The Uno to IDLE, however it is met; what an earlier host left is said by name, once, before it is forgotten."""
        self.uno.hello()
        status = self.uno.heartbeat()
        if status.state not in (State.IDLE, State.FAULT):
            left = f"the Uno was left in state {status.state.name} by another host, or by one that was killed; it is disarmed"
            warnings.warn(left, DampyrWarning, stacklevel=4)
            self.uno.disarm()
            status = self.uno.heartbeat()
        if status.state is State.FAULT:
            if not self._taken_over and status.faults & ~(Fault.RESTARTED | Fault.ABORTED):
                words = fault_in_words(status.faults, not status.homed or status.outside)
                stopped = f"the Uno had stopped by itself before this host came: {words}"
                warnings.warn(stopped, DampyrWarning, stacklevel=4)
            self.uno.clear()
        self._taken_over = True

    def listen(self, seconds: float = 1.0) -> tuple[Array, NDArray[np.int64]]:
        """What the board reads while nothing is armed: volts (channels, n) and counts (n,); the command is 0 V."""
        rate, n = self.settings.board.rate, max(2, round(seconds * self.settings.board.rate))
        self.board.start(rate, np.zeros(n + 1))
        try:
            return self.board.read(n)
        finally:
            self.board.stop()

    def monitor(self, block: float = 0.05) -> Generator[Samples, None, None]:
        """Blocks of ``block`` [s] while the rig is not armed, without end: nothing moves, and the command is 0 V.

        Displacements are counted from the middle where the table is homed, else from where it stands. Close the iterator
        before anything else is asked of the rig.
        """
        calibration, n = self.calibration, max(2, round(block * self.settings.board.rate))
        assert calibration is not None
        self._cool_since_last_read()
        self.warmth.restart()
        self.board.start(self.settings.board.rate, np.zeros(n))
        try:
            self.board.write(0.0)  # what was queued is dropped: reading needs no command
            first, middle = 0, None
            while True:
                volts, counts = self.board.read(n)
                status = self.uno.heartbeat()
                if middle is None:
                    middle = float(counts[-1]) - (status.position if status.homed else 0.0)
                    calibration = replace(calibration, middle=middle)
                readings = dict(zip(self.settings.inputs, volts, strict=True))
                volts_at_coil = readings.get("coil_voltage", np.zeros(n)) * self.settings.supply.voltage_scale
                samples = Samples(
                    first,
                    np.arange(first, first + n) / self.settings.board.rate,
                    calibration.displacement(counts),
                    calibration.force(volts[0]),
                    calibration.temperature(readings["temperature"]) if "temperature" in readings else None,
                    volts,
                    counts,
                    volts_at_coil,
                    status,
                )
                self.warmth.take(samples)
                yield samples
                first += n
        finally:
            self._read_until = self.clock()
            self.board.stop()

    def use(self, calibration: Calibration) -> None:
        """Use ``calibration`` from the next arming on, with what it says of the rig's parts."""
        self.calibration, self.settings = calibration, calibration.corrected(self.settings)
        self.warmth.rig = self.settings

    @cached_property
    def identity(self) -> str:
        """The board, the supply if it is another instrument, and the drive's firmware."""
        drive = "Uno" if self.settings.wires.drive == "arduino-uno" else "drive's"
        return f"{self.board.identity()}, {drive} firmware {self.uno.hello().firmware}"

    @cached_property
    def origin(self) -> Origin:
        """Origin of what it records: "measured" only where the driver of its board says so."""
        if self.simulated or of_board(self.identity).kind == "simulated":
            return SIMULATED
        return stated_origin(self.board)

    @cached_property
    def command_delay(self) -> float:
        """s by which a change of the coil's voltage may be late: 0 where the command has the samples' clock."""
        return 0.0 if self.settings.wires.supply == OUTPUT else float(cast(Any, self.board).command_delay())

    def close(self) -> None:
        """Close the instruments; each is tried, and the first failure is raised."""
        self._close(None)

    def _close(self, problem: BaseException | None) -> None:
        """Close the instruments; failures are noted on ``problem``, or the first is raised where there is none."""
        failed: list[Exception] = []
        for close in (self.uno.close, self.board.close, *self.on_close):
            try:
                close()
            except Exception as trouble:  # whatever it is, the next one is closed
                failed.append(trouble)
        self.on_close.clear()
        _report(failed, problem)

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, _: object, problem: BaseException | None, __: object) -> None:
        self._close(problem)


def _leave(table: ArmedRig, problem: BaseException | None) -> None:
    """Disarm, whatever interrupts it; ``problem`` is what ended the block."""
    try:
        with deferred_signals(discard=problem is not None):
            table.disarm(problem)
    except (KeyboardInterrupt, SystemExit) as interruption:  # just before the deferral, or right after it
        with deferred_signals(discard=True):
            table.disarm(problem or interruption)
        raise


def _report(failed: Sequence[Exception], problem: BaseException | None) -> None:
    """Note failures on ``problem``, the first reason; without one, raise the first of them."""
    if failed and problem is None:
        for failure in failed[1:]:
            failed[0].add_note(str(failure))
        raise failed[0]
    if problem is not None:
        for failure in failed:
            problem.add_note(str(failure))


class ArmedRig(Shown):
    """An armed rig. Everything is in m, s, N and V; displacement from the middle of the stroke, extension positive.

    ``check`` is called for every block while something is waited for; what it raises ends the waiting, and `stop` the motion.
    """

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.loop = rig.make_loop(rig)
        self.check: Callable[[], None] = no_check
        steps = (self.loop.cut, self._stop, self.loop.end, self.loop.settle, self._disarm_uno, self._stop_board)
        self.passes: list[SlowPass] = []
        """What was seen each time that `verify` has looked."""
        self.specimen = ""
        """The damper on the table, as the campaign or the rig's file names it."""
        self.earlier: SlowPass | None = None
        """What the first of these is compared with, by the passes that are kept of earlier runs; None without one."""
        self.shunts: list[ShuntStep] = []
        """The step of the shunt across the load cell's bridge, where one is wired, each time that `verify` has looked."""
        self._way_out: deque[Callable[[], None]] = deque(steps)

    def begin(self) -> None:
        """Start sampling and arm; the board and the Uno are aligned where the table rests."""
        if self.rig.settings.wires.shunt:
            switch_shunt(self.rig.board, False)  # another host may have been killed while it was on
        self.loop.begin()
        self.ask_uno(self.rig.uno.heartbeat, self.rig.uno.arm)
        for samples in self._blocks_for(SETTLED):  # without the lock: the thread that reads needs it for a block
            if samples.status.speed == 0:
                break
        self._align()

    def disarm(self, problem: BaseException | None) -> None:
        """Coil to 0 V, stop, rest, disarm; each is tried; failures are noted on ``problem`` or raised.

        Called again, it goes on after the last step that was made.
        """
        failed: list[Exception] = []
        with suppress(RigFault):  # one of a process that has ended plays nothing
            self.loop.end_drive()
        while self._way_out:
            step = self._way_out[0]
            try:
                with self.loop.lock if step in (self._stop, self._disarm_uno) else nullcontext():
                    step()
            except Exception as trouble:  # whatever it is, the next step is tried
                failed.append(trouble)
            self._way_out.popleft()
        _report(failed, problem)

    def _stop(self) -> None:
        """Decelerate, or brake where that fails."""
        try:
            self.rig.uno.stop()
        except RigFault:
            self.rig.uno.abort()
            raise

    def _disarm_uno(self) -> None:
        self.rig.uno.disarm()

    def _stop_board(self) -> None:
        self.rig.board.stop()

    def ask_uno(self, *requests: Callable[[], object]) -> None:
        """Make requests of the Uno between two blocks; where one is refused as the rig has been stopped, that is raised."""
        try:
            with self.loop.lock:
                for request in requests:
                    request()
        except RigFault as problem:
            raise self.loop.reason(problem) from None

    @property
    def position(self) -> float:
        """The table's position as the Uno reports it [m]."""
        return self.loop.status.position * self.rig.settings.encoder.count

    @property
    def homed(self) -> bool:
        """Whether the Uno's position is homed."""
        return self.loop.status.homed

    @property
    def temperature(self) -> float:
        """The damper's temperature [degC], measured or estimated."""
        return self.rig.warmth.temperature

    def home(self, here: bool = False) -> None:
        """Find the middle of the stroke by the index mark; ``here``: the table is in it."""
        if self.loop.status.outside and not here:
            self.come_back()
        self.ask_uno(partial(self.loop.home, here))
        self.rig.homed_by_hand = here
        for samples in self._blocks_for(HOMING):
            if samples.status.state is State.ARMED:
                if samples.status.homed:
                    self._align()
                    return
                break
        raise RigFault("no index mark was found; look at the encoder, or home by hand in the middle")

    def come_back(self) -> None:
        """Move a homed table that stands outside of its limits slowly back to within them; nothing where it is within."""
        count = self.rig.settings.encoder.count
        out = abs(self.position) - self.rig.settings.travel
        for _ in range(math.ceil(max(out, 0.0) / (SLOW * count * BACK)) + 5):
            if not self.loop.status.outside:
                break
            speed = -SLOW if self.position > 0.0 else SLOW
            self.ask_uno(partial(self.rig.uno.jog, speed, round(1000 * (BACK + 0.1))))
            self.rest(BACK)
        self.stop()
        if self.loop.status.outside:
            raise RigFault(
                f"the table stands at {self.position * 1e3:.2f} mm, outside of its limits, and does not come back; look at "
                "the motor, its driver and the screw",
                "check",
            )

    def verify_index(self) -> None:
        """Pass the encoder's index slowly, where it lies within the travel: :class:`RigFault` where it is not where homing put
        it, for then the positions since its last pass were wrong.
        """
        if not self.pass_index():
            raise RigFault(INDEX_GONE, "check")

    def pass_index(self) -> bool:
        """Pass the encoder's index slowly, where it lies within the travel; whether it was there. Where not, the table is no
        longer homed, for this host and for the next. :class:`RigFault` where it has moved by more than 2 counts.
        """
        if not self.homed:
            return False
        at, count = self.position, self.rig.settings.encoder.count
        place = self.loop.index.get(0)
        if place is None:
            if self.rig.homed_by_hand:
                return True
            place = round(self.rig.settings.encoder.index / count)  # another host has homed it
        side = PAST_INDEX if at <= place * count else -PAST_INDEX
        if abs(place * count) + PAST_INDEX > self.rig.settings.travel - OVERSHOOT:
            return True
        if abs(at - place * count) < PAST_INDEX:
            self.go(place * count - side)
        before = self.loop.status.index_passes
        self.go(place * count + side)
        if self.loop.status.index_passes != before:
            return True
        self.loop.home(here=False)  # a search that is broken off has lost its place
        self.stop()
        return False

    def verify(self) -> None:
        """Pass the encoder's index as `verify_index` does, and append to `passes` the force [N] about which the damper's
        hysteresis lies, and half of the hysteresis itself, with the coil at 0 V.

        The former is the mean of the forces on a slow way down and up again over the same place, (F- + F+)/2: friction and
        damping cancel, and what is left, the zero of the load cell and the static force there, changes with neither. The
        latter, (F+ - F-)/2, is friction and damping alone: it changes with the gain of the load cell's chain, and with no
        zero. Where a shunt is wired (``wires.shunt``), it is switched in and out then, and its step appended to `shunts`.
        Nothing where the table is not homed.
        """
        if not self.homed:
            return
        index, passes = self.loop.index.get(0), self.loop.status.index_passes
        place = (index or 0) * self.rig.settings.encoder.count
        if index is None or abs(place) + SIDE > self.rig.settings.travel - OVERSHOOT:
            self.verify_index()
            place, passes = 0.0, -1
        self.go(place + SIDE)
        means, readings = [], []
        for way in (-1.0, 1.0):
            samples = list(self._move_slowly(place + way * SIDE))
            readings += [block.volts[0] for block in samples]
            x = np.concatenate([block.displacement for block in samples])
            force = np.concatenate([block.force for block in samples])
            # Only the middle half of the way: there the hysteresis has saturated, and the table moves at its full speed.
            means.append(float(np.mean(force[np.abs(x - place) < 0.5 * SIDE])))
        if self.loop.status.index_passes == passes:
            raise RigFault(INDEX_GONE, "check")
        settings = self.rig.settings
        cell = settings.load_cell
        self.passes.append(
            SlowPass(
                mean=0.5 * sum(means),
                height=0.5 * (means[1] - means[0]),
                noise=least_noise(np.concatenate(readings), settings.board.rate, settings.step),
                temperature=self.temperature,
                place=place,
                specimen=self.specimen,
                cell=cell_of(self.loop.calibration, cell.scale_uncertainty, cell.bandwidth),
                time=datetime.now(UTC).isoformat(timespec="seconds"),
            )
        )
        if self.rig.settings.wires.shunt:
            self.shunts.append(self.shunt_step())

    def shunt_step(self) -> ShuntStep:
        """Switch the shunt across the load cell's bridge in and out again, at rest: the step of the force."""
        board, settle = self.rig.board, partial(self._force_at_rest, SHUNT_SETTLED)
        before = self._force_at_rest(READ)
        try:
            switch_shunt(board, True)
            after = np.concatenate([settle(), self._force_at_rest(READ)])
        finally:
            switch_shunt(board, False)
        settle()
        return step_of(before, after, self.rig.settings.board.rate)

    def _force_at_rest(self, seconds: float) -> Array:
        """The force of so many seconds from now on [N]."""
        return np.concatenate([samples.force for samples in self._blocks_for(seconds)])

    def _align(self) -> None:
        """Align the board's counts with the Uno's, at rest: in a block in which the table moves, they are read at
        different times."""
        self.loop.realign()
        self.rest(self.rig.settings.board.block)

    def zero_force(self, seconds: float = 1.0) -> float:
        """Zero the force at the mean signal at rest; the volts."""
        volts = self.signal(seconds)
        zeroed = self.loop.calibration.zeroed(volts)
        self.calibrate(replace(zeroed, how=f"{zeroed.how.removesuffix(ZEROED)}{ZEROED}"))
        return volts

    def signal(self, seconds: float = 1.0) -> float:
        """The load cell's mean signal [V]."""
        return float(np.mean(np.concatenate([samples.volts[0] for samples in self._blocks_for(seconds)])))

    def calibrate(self, calibration: Calibration) -> None:
        """Use ``calibration`` from the next block on."""
        self.rig.calibration = calibration
        self.loop.use(calibration)

    def rest(self, seconds: float) -> None:
        """Keep reading for ``seconds``."""
        for _ in self._blocks_for(seconds):
            pass

    def compare_clocks(self) -> None:
        """Keep reading until the Uno's clock is known well enough against the board's for a path that is learned or computed.

        :class:`RigFault` where it is not after a minute: the line's latency is too uneven then.
        """
        for _ in range(COMPARING):
            if self.loop.clock_ratio.known:
                return
            self.rest(1.0)
        raise RigFault(
            f"{self.loop.clock_ratio} after {COMPARING} s, and a drive that is learned or computed needs "
            f"{1e6 * KNOWN:.0f} ppm; look at the Uno's serial line and at what else this machine does",
            "check",
        )

    def meanwhile(self, work: Callable[[], object]) -> None:
        """Do slow work, such as finishing a long record, and keep reading: a rig whose host is silent stops.

        One whose time passes only while it is read is left alone, so that its records do not depend on how long work takes.
        """
        if self.rig.clocked_by_reads:
            work()
            return
        with ThreadPoolExecutor(1, "meanwhile") as pool:
            done = pool.submit(work)
            wait([done], timeout=QUICK)
            while not done.done():
                next(self.loop.blocks())
        done.result()

    def jog(self, speed: float, seconds: float = 0.2, wait: bool = True) -> None:
        """Move at ``speed`` [m/s] for a while, at most 0.5 s; without ``wait`` return at once, so that it can be renewed."""
        if not 0.0 < seconds <= 0.5:
            raise InputError(f"seconds = {seconds:g} is not allowed; a jog lasts at most 0.5 s, and is asked for again")
        fastest = self.rig.settings.limits.speed
        if not abs(speed) <= fastest:
            raise InputError(
                f"speed = {speed * 1e3:g} mm/s is not allowed; a jog has at most {fastest * 1e3:g} mm/s (limits.speed)"
            )
        self.ask_uno(partial(self.rig.uno.jog, round(speed / self.rig.settings.encoder.count), round(seconds * 1000)))
        for samples in self._blocks_for(seconds + 0.2) if wait else ():
            if samples.status.state is State.ARMED:
                return

    def go(self, displacement: float) -> None:
        """Move slowly to ``displacement`` [m] and stop there; :class:`RigFault` where the table did not follow.

        Raises :class:`InputError`, before anything moves, for a place outside of the travel or a table that is not homed.
        """
        self.check_place(displacement)
        for _ in self._move_slowly(displacement):
            pass

    def check_place(self, place: float, name: str = "displacement") -> None:
        """Raise :class:`InputError` where the table cannot go to ``place`` [m], called ``name``, or is not homed."""
        farthest = round(self.rig.settings.travel - OVERSHOOT, 9)
        if not abs(place) <= farthest:
            raise InputError(
                f"{name} = {place * 1e3:g} mm is not allowed; the table goes from {-farthest * 1e3:g} mm to "
                f"{farthest * 1e3:g} mm"
            )
        self.check_homed()

    def check_homed(self) -> None:
        """Raise :class:`InputError` where the table is not homed."""
        if not self.homed:
            raise InputError("the table is not homed, so its middle is not known; home the table first")

    def _move_slowly(self, displacement: float) -> Iterator[Samples]:
        """The blocks of a slow move."""
        if self.loop.status.outside:
            self.come_back()
        path = displacement - self.position
        seconds = max(1.875 * abs(path) / GENTLE, 0.1)  # a minimum-jerk path's peak speed is 15/8 of its mean
        n = math.ceil(seconds / 0.01) + 1
        s = np.linspace(0.0, 1.0, n)
        smooth = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)  # speed and acceleration are 0 at both ends
        for samples, _ in self.play(Drive(0.01, self.position + path * smooth, np.zeros(n))):
            yield samples
        short = max(STANDING, min(ARRIVED, 0.5 * abs(path)))  # a motor that stands is seen in a short move, too
        if abs(displacement - self.position) > short:
            raise RigFault(
                f"the table was driven to {displacement * 1e3:.2f} mm and stands at {self.position * 1e3:.2f} mm; "
                "look at the motor, its driver and the screw",
                "check",
            )

    def play(self, drive: Drive) -> Iterator[tuple[Samples, slice]]:
        """Play a drive: each block, and which of its samples belong to the record; the table must be where the drive begins.

        Raises :class:`InputError` where it does not, before anything moves, and :class:`RigFault` where a safety layer acts.
        """
        driven = drive.reversals is None and not drive.standing
        if driven and abs(drive.displacement[0] - self.position) > ARRIVED:
            raise InputError(
                f"the drive begins at {drive.displacement[0] * 1e3:.2f} mm and the table stands at "
                f"{self.position * 1e3:.2f} mm; call go() first"
            )
        if self.rig.command_delay and np.ptp(drive.voltage) > 0.0:
            late = f"{1e3 * self.rig.command_delay:.0f} ms"
            no_clock = f"the supply has no sample clock: steps of its voltage come up to {late} late"
            warnings.warn(no_clock, DampyrWarning, stacklevel=2)
        player = self.loop.play(drive)
        try:
            yield from self._play_blocks(player, drive)
        finally:
            self.loop.end_drive()

    def _play_blocks(self, player: Player, drive: Drive) -> Iterator[tuple[Samples, slice]]:
        for samples in self.loop.blocks():
            yield samples, player.recorded_slice(samples.first, samples.n)
            self.check()
            if drive.until_temperature is not None and self.temperature >= drive.until_temperature:
                self.stop()
                return
            if samples.first + samples.n >= player.end and player.finished:
                break
        else:
            return
        self._stand()

    def _stand(self) -> None:
        """Read on until the table stands, so that what the interlock compares at rest has been compared."""
        still = 0
        for samples in self._blocks_for(SETTLED):
            still = still + 1 if samples.status.speed == 0 and np.ptp(samples.counts) == 0 else 0
            if still == 2:
                return

    def stop(self) -> None:
        """Decelerate to rest, and stay armed."""
        self.loop.end_drive()
        self.ask_uno(self.rig.uno.stop)
        for samples in self._blocks_for(SETTLED):
            if samples.status.state is State.ARMED:
                return

    def soft_stop(self) -> None:
        """Cut the coil and decelerate, whatever fails; `disarm` follows."""
        with suppress(RigFault):
            self.loop.end_drive()
        with self.loop.lock:
            for step in (self.loop.cut, self.rig.uno.stop):
                with suppress(RigFault):
                    step()

    def abort(self, why: str = "it was asked for") -> None:
        """Cut the coil and brake, now; from any thread. Whoever waits for blocks gets a :class:`RigFault`."""
        self.loop.halt(RigFault(f"aborted: {why}", "operator"))

    def _blocks_for(self, seconds: float) -> Iterator[Samples]:
        """Blocks of ``seconds`` read from now on; those that wait already are older."""
        begin = self.loop.next
        last = begin + round(seconds * self.rig.settings.board.rate)
        for samples in self.loop.blocks():
            self.check()
            if samples.first < begin:
                continue
            yield samples
            if samples.first + samples.n >= last:
                return


def no_check() -> None:
    """A check that never stops."""
