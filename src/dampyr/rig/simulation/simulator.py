"""The simulated rig in one piece: the plant, the Uno and the ends of the board, on one clock that moves when asked to."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from time import sleep

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind
from dampyr.rig.firmware.twin import Twin
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.board_signals import (
    DEGREES_PER_VOLT,
    OVERRUN,
    TIMEOUT,
    UNDERFLOW,
    BoardError,
    command_of,
    converted,
    volts_of_force,
)
from dampyr.rig.simulation.constants import DELAYED, constants_of
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.ground_truth import Truth, TruthLog
from dampyr.rig.simulation.specimen import force_at_rest, specimen_of, table_of, with_play
from dampyr.rig.simulation.timed_command import TimedCommand

Array = NDArray[np.float64]
EventListener = Callable[[float, str], None]
STEP = 1e-4  # s of the plant
BEAT = 0.02  # s that a heartbeat moves the clock by while no task samples
WANDERS = 0.5  # s of memory of the load cell's slow errors
BUFFER = 10.0  # s of samples that the board holds


@dataclass
class Task:
    """The sampled task: when it was started [s], its rate, and what has not been read yet."""

    start: float
    period: float
    taken: int = 0
    volts: Array | None = None
    counts: NDArray[np.int64] | None = None


class Simulator:
    """The simulated rig.

    Parameters
    ----------
    settings, seed
        What it is made of; the seed of noise and lost bytes: the same calls with the same seed give the same bits.
    faults
        What goes wrong, and when.
    specimen
        The damper on the table; None: the card that the settings name.
    position
        Where the table rests at first, m from the middle.
    step
        s of the plant's integration; a millisecond must be a whole number of steps.
    told
        Called with the time and a sentence for each thing that happens ("enable low", "coil dead", "at rest" ...).
    """

    def __init__(
        self,
        settings: RigSettings,
        seed: int = 0,
        faults: Sequence[FaultSpec] = (),
        specimen: Damper | None = None,
        position: float = 0.0,
        step: float = STEP,
        on_event: EventListener | None = None,
    ) -> None:
        self.settings, self.faults = settings, tuple(faults)
        self.specimen = with_play(specimen_of(settings) if specimen is None else specimen, settings.specimen.free_play)
        self.constants = constants_of(settings, self.specimen, step)
        self.noise, self.luck, self.slow = (np.random.default_rng([seed, k]) for k in range(3))
        self.twin = Twin(self._beaten)
        self.tracks = TruthLog(on_event)
        self._task: Task | None = None
        self.timed: TimedCommand | None = None
        self._commanded = 0.0
        self._wander = settings.load_cell.wander * float(self.slow.standard_normal())
        self._begun: set[FaultSpec] = set()
        self.beat = BEAT
        self.wait: Callable[[float], None] = sleep
        self._kernel = bind(plant.run, (self.specimen.composition,))
        self._lay_out(position)

    def _lay_out(self, position: float) -> None:
        """The rows that the kernel works on, at rest."""
        m, composition = self.constants, self.specimen.composition
        if not abs(position) < m.stroke:
            raise InputError(f"position = {position:g} m must be within the stroke of +-{m.stroke:g} m")
        self.plant, self.numbers, self.wrong = np.zeros(plant.PLANT), np.zeros(plant.NUMBERS, np.int64), np.zeros(4)
        self.plant[[plant.Y_SCREW, plant.Y_X]] = position
        self.plant[plant.Y_TEMPERATURE] = m.ambient_temperature
        self.numbers[plant.N_SHOWN] = np.floor(position / m.pulse)
        self.numbers[plant.N_NI] = -self.numbers[plant.N_SHOWN]
        self.numbers[plant.N_UNO] = -self.numbers[plant.N_SHOWN]
        self.states, self.parameters = np.array(composition.state0, float), np.zeros(len(composition.parameters))
        self.table = table_of(self.specimen)
        self.static = np.isin(np.arange(self.parameters.size), composition.static).astype(float)
        start = force_at_rest(self.specimen, position)
        self.plant[[plant.Y_FORCE, plant.Y_CELL]] = start
        self.past = np.full(DELAYED, start)

    # what the host does

    @property
    def time(self) -> float:
        """s, simulated."""
        return float(self.numbers[plant.N_STEP] * self.constants.dt)

    @property
    def sampling(self) -> bool:
        """Whether the sampled task runs."""
        return self._task is not None

    def serial(self, data: bytes) -> bytes:
        """Bytes from the host -> what the Uno sends back, now."""
        self._begin_faults()
        if self._holding("unplugged-serial"):
            return b""
        said = self.twin.receive(self._thinned(data))
        self.tracks.see(self)
        return self._thinned(said)

    def start(self, rate: float) -> None:
        """Start the sampled task: the inputs and the counter on one clock of ``rate`` Hz, first sample one period from now."""
        if self._task is not None:
            raise InputError("the sampled task runs already; stop it first")
        if not 0.0 < rate <= 250000.0:
            raise InputError(f"rate = {rate:g} Hz is not allowed; it must be greater than 0 and at most 250000")
        self.numbers[plant.N_NI] = -self.numbers[plant.N_SHOWN]
        self._task = Task(self.time, 1.0 / rate)

    def stop(self) -> None:
        """Stop the sampled task; what was not read is lost. Nothing where none runs."""
        self._task = None

    def read(self, n: int) -> tuple[Array, NDArray[np.int64]]:
        """The next ``n`` samples, volts (channels, n) and counts (n,), counted from where the task was started.

        Moves the clock until they exist. Channels: force, and the temperature where the rig has one. BoardError as the
        board gives it.
        """
        task = self._task
        if task is None:
            raise InputError("no sampled task runs; start it first")
        if n < 1:
            raise InputError(f"n = {n} samples; read at least 1")
        done = task.taken - self.waiting
        patience = self.time + n * task.period if self._holding("board-timeout") else 0.0
        self.advance_to(max(task.start + (done + n) * task.period, patience))
        self._hinder(task)
        assert task.volts is not None
        assert task.counts is not None
        volts, counts = task.volts[:, :n], task.counts[:n]
        task.volts, task.counts = task.volts[:, n:], task.counts[n:]
        return volts, counts

    def look(self) -> tuple[Array, int]:
        """Volts (channels,) and the count of now, without a clock and without moving it; BoardError as for `read`."""
        self._begin_faults()
        self._hinder(Task(self.time, 1.0))
        wrong = self._holding("broken-cell"), self._holding("drifting-cell")
        volts = self._volts(Task(self.time, 0.0), self.plant[[plant.Y_CELL]], *wrong)
        return volts[:, 0], int(self.numbers[plant.N_SHOWN] + self.numbers[plant.N_NI])

    def _hinder(self, task: Task) -> None:
        """What faults of the board do to a read."""
        if self._holding("board-timeout"):
            raise BoardError(TIMEOUT)
        if self._holding("board-overrun") or self.waiting * task.period > BUFFER:
            raise BoardError(OVERRUN)
        late = self._holding("late-samples")
        if late is not None:
            self.wait(late.size)

    @property
    def waiting(self) -> int:
        """How many samples exist that were not read."""
        return 0 if self._task is None or self._task.counts is None else self._task.counts.size

    def queue(self, volts: Array) -> None:
        """Append to the timed command; BoardError where there is none, or it ran out."""
        if self.timed is None or self.timed.empty(self.time):
            raise BoardError(UNDERFLOW)
        self.timed.queue(volts)

    def write(self, volts: float) -> None:
        """The command voltage, now; BoardError beyond the board's range."""
        self._commanded = volts
        self.plant[plant.Y_COMMAND] = command_of(self.settings, volts)

    @property
    def command(self) -> float:
        """The command voltage that the board holds, V."""
        return float(self.plant[plant.Y_COMMAND])

    def alone(self, seconds: float) -> None:
        """Run on without a host."""
        self.advance_to(self.time + seconds)

    # what happened

    @property
    def truth(self) -> Truth:
        """What really happened, once a millisecond."""
        return self.tracks.truth()

    @property
    def at_rest_since(self) -> float:
        """Since when the table has stood, s; NaN while it moves."""
        return self.tracks.at_rest_since

    @property
    def coil_dead_since(self) -> float:
        """Since when no voltage and less than 10 mA has been at the coil, s; NaN while there is."""
        return self.tracks.coil_dead_since

    # the clock

    def advance_to(self, time: float) -> None:
        """Move the clock on to ``time``, s; samples are taken and kept where the task runs."""
        last = int(np.ceil(time / self.constants.dt - 1e-6))
        while self.numbers[plant.N_STEP] < last:
            self._begin_faults()
            self._advance(min(last, self._next_change(), int(self.numbers[plant.N_STEP]) + 100000))
            self._put_out()
        self._begin_faults()

    def _put_out(self) -> None:
        """The value of the timed command that is due."""
        value = None if self.timed is None else self.timed.due(self.time)
        if value is not None and value != self._commanded:
            self.write(value)

    def _advance(self, until: int) -> None:
        """Steps between which no fault begins or ends."""
        here, task = int(self.numbers[plant.N_STEP]), self._task
        start, period, wanted = (0.0, 1.0, 0) if task is None else (task.start, task.period, self._due(task, until))
        start += 0.0 if task is None else task.taken * task.period
        forces, counts = np.empty(wanted), np.empty(wanted, np.int64)
        rows = np.empty(((until // self.constants.per_tick) - (here // self.constants.per_tick), len(plant.TRUTH)))
        self.numbers[plant.N_TAKEN] = 0
        wrong = self._holding("broken-cell"), self._holding("drifting-cell")
        given = (self.states, self.parameters, self.table, self.static, self.past, self.twin.registers)
        self._kernel(
            until, self.constants, self.plant, self.numbers, self.wrong, *given, start, period, forces, counts, rows
        )
        self.tracks.add(rows)
        if task is not None and wanted:
            taken = self.numbers[plant.N_TAKEN]
            self._keep(task, self._volts(task, forces[:taken], *wrong), counts[:taken])

    def _due(self, task: Task, until: int) -> int:
        """How many samples of ``task`` fall into the steps up to ``until``, or one more."""
        last = (until * self.constants.dt - task.start) / task.period
        return max(0, int(np.floor(last + 1e-6)) - task.taken)

    def _keep(self, task: Task, volts: Array, counts: NDArray[np.int64]) -> None:
        """Samples beside those not read yet."""
        task.taken += counts.size
        task.volts = volts if task.volts is None else np.concatenate((task.volts, volts), axis=1)
        task.counts = counts if task.counts is None else np.concatenate((task.counts, counts))

    def _volts(self, task: Task, forces: Array, broken: FaultSpec | None, drifting: FaultSpec | None) -> Array:
        """The analogue inputs (channels, n) of samples with the filtered forces given."""
        noisy = forces + self.settings.load_cell.noise * self.noise.standard_normal(forces.size)
        noisy += self._wandering(forces.size, task.period)
        if drifting is not None:
            time = task.start + (task.taken + 1 + np.arange(forces.size)) * task.period
            noisy += drifting.size * (time - drifting.at)
        volts = volts_of_force(self.settings, noisy)
        if broken is not None:
            volts = np.full_like(volts, broken.size)
        rows = [volts]
        if self.settings.wires.temperature:
            rows.append(np.full_like(volts, self.plant[plant.Y_TEMPERATURE] / DEGREES_PER_VOLT))
        return converted(self.settings, np.stack(rows))

    def _wandering(self, n: int, period: float) -> Array:
        """Slow errors of the load cell: an Ornstein-Uhlenbeck process, stationary from the start."""
        from scipy.signal import lfilter

        decay = np.exp(-period / WANDERS)
        pushes = self.settings.load_cell.wander * np.sqrt(1.0 - decay**2) * self.slow.standard_normal(n)
        rows, _ = lfilter([1.0], [1.0, -decay], pushes, zi=[decay * self._wander])
        self._wander = float(rows[-1]) if n else self._wander
        return np.asarray(rows)

    def _beaten(self) -> None:
        """A heartbeat moves the clock while nothing is sampled."""
        if self._task is None:
            self.alone(self.beat)

    # faults

    def _holding(self, *kinds: str) -> FaultSpec | None:
        """The fault of one of these kinds that holds now."""
        now = self.time + 1e-9
        return next((f for f in self.faults if f.kind in kinds and f.at <= now < f.until), None)

    def _next_change(self) -> int:
        """The step at which the next fault begins or ends."""
        command = np.inf if self.timed is None else self.timed.next_change(self.time, self._commanded)
        changes = [command] + [
            time for fault in self.faults for time in (fault.at, fault.until) if time > self.time + 1e-9
        ]
        finite = [time for time in changes if np.isfinite(time)]
        return int(np.ceil(min(finite) / self.constants.dt - 1e-6)) if finite else np.iinfo(np.int64).max

    def _begin_faults(self) -> None:
        """Set what holds now, and do once what is done once."""
        if not self.faults:
            return
        self.wrong[plant.Z_STALLED] = self._holding("stalled-motor") is not None
        self.wrong[plant.Z_UNO] = self._holding("stuck-encoder", "stuck-encoder-uno") is not None
        self.wrong[plant.Z_NI] = self._holding("stuck-encoder", "stuck-encoder-board") is not None
        self.wrong[plant.Z_GLITCH] = self._holding("glitching-encoder") is not None
        for fault in self.faults:
            if fault not in self._begun and fault.at <= self.time + 1e-9:
                self._begun.add(fault)
                self.tracks.tell(self.time, f"fault {fault}")
                if fault.kind == "hot-specimen":
                    self.plant[plant.Y_TEMPERATURE] += fault.size
                if fault.kind == "restarted-uno":
                    self.twin.restart()

    def _thinned(self, data: bytes) -> bytes:
        """Bytes that pass the serial wire."""
        lost = self._holding("lost-bytes")
        if lost is None:
            return data
        return bytes(byte for byte, luck in zip(data, self.luck.random(len(data)), strict=True) if luck >= lost.size)


def parse_faults(texts: Iterable[str]) -> tuple[FaultSpec, ...]:
    """Faults as typed."""
    return tuple(map(FaultSpec.parse, texts))
