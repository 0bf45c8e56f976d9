"""The simulated rig: the plant, the Uno and the signals of the board on one simulated clock, advanced by its caller."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import sleep

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind
from dampyr.rig.calibration import shunt_force
from dampyr.rig.firmware.control_core import R_DUTY
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
from dampyr.rig.simulation.chip import Chip, ChipFirmware
from dampyr.rig.simulation.constants import DELAYED, constants_of
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.ground_truth import Truth, TruthLog
from dampyr.rig.simulation.plant_specimen import add_free_play, force_at_rest, table_of
from dampyr.rig.simulation.timed_command import TimedCommand
from dampyr.rig.specimen import specimen_of

Array = NDArray[np.float64]
EventListener = Callable[[float, str], None]
STEP = 1e-4  # s of the plant: ten steps to a tick of the firmware
HEARTBEAT_INTERVAL = (
    0.02  # s that a heartbeat advances the clock while no task samples: seven fit in the watchdog's 0.15 s
)
WANDER_TIME = 0.5  # s, correlation time of the load cell's slow errors; assumed
START_UP = 5e-3  # s until the firmware's binary listens
OF_THE_MODEL = {
    "stuck-encoder", "stuck-encoder-uno", "glitching-encoder", "swapped-encoder", "slipped-encoder", "restarted-uno",
}  # fmt: skip
CELL_FAULTS = ("broken-cell", "drifting-cell", "inverted-cell", "cell-clip", "cell-gain", "cell-slow")
BUFFER = 10.0  # s of samples that the board buffers: what the driver asks NI-DAQmx for


@dataclass
class SampledTask:
    """The sampled task: its start [s], its period, and the samples not read yet."""

    start: float
    period: float
    taken: int = 0
    volts: Array | None = None
    counts: NDArray[np.int64] | None = None


@dataclass(frozen=True)
class Hand:
    """What a person does at the table: turns its screw at ``speed`` [m/s], pulls at the load cell with ``force`` [N], opens an
    end switch (-1 the lower one, 1 the upper one), presses the emergency stop."""

    speed: float = 0.0
    force: float = 0.0
    switch: int = 0
    pressed: bool = False


class Simulator:
    """The simulated rig.

    Parameters
    ----------
    settings, seed
        The rig's parts; the seed of noise and lost bytes: the same calls with the same seed give the same bits.
    faults
        What goes wrong, and when.
    specimen
        The damper on the table; None: the card that the settings name.
    position
        Where the table rests at first, m from the middle.
    step
        s of the plant's integration; a millisecond must be a whole number of steps.
    chip
        A simulator of the chip with the program and the binary of the firmware, which take the place of its model; it knows no
        faults of the encoder and of the Uno. None: the model.
    on_event
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
        chip: tuple[str | Path, str | Path] | None = None,
    ) -> None:
        self.settings, self.faults = settings, tuple(faults)
        self.specimen = add_free_play(
            specimen_of(settings) if specimen is None else specimen, settings.specimen.free_play
        )
        self.constants = constants_of(settings, self.specimen, step)
        self.noise_rng, self.loss_rng, self.wander_rng, self.line_rng = (
            np.random.default_rng([seed, k]) for k in range(4)
        )
        self.twin: Twin | ChipFirmware = Twin(self._on_heartbeat)
        self.twin.build = (int(settings.wires.direction_pin), settings.wires.baud, *self.twin.build[2:])
        self.truth_log = TruthLog(on_event)
        self._task: SampledTask | None = None
        self._index_taken = 0
        self.timed: TimedCommand | None = None
        self._commanded = 0.0
        self._wander = settings.load_cell.wander * float(self.wander_rng.standard_normal())
        self._relay = 0.0  # N, what the shunt of the rig simulates while its relay is on
        self._hand = Hand()
        self._slow_noise = 0.0  # N, the last of the noise that a slow amplifier has let through
        self._started_faults: set[FaultSpec] = set()
        self._stuck_temperature = settings.specimen.room
        self.heartbeat_interval = HEARTBEAT_INTERVAL
        self.delay_read: Callable[[float], None] = sleep
        self._kernel = bind(plant.run, (self.specimen.composition,))
        self._initialise(position)
        if chip is not None:
            self._use_chip(*chip)

    def _initialise(self, position: float) -> None:
        """Set the arrays that the kernel works on, at rest."""
        m, composition = self.constants, self.specimen.composition
        if not abs(position) < m.stroke:
            raise InputError(f"position = {position:g} m must be within the stroke of +-{m.stroke:g} m")
        self.plant, self.counters, self.fault_flags = (
            np.zeros(plant.PLANT),
            np.zeros(plant.NUMBERS, np.int64),
            np.zeros(plant.FLAGS),
        )
        self.plant[[plant.Y_SCREW, plant.Y_X]] = position
        self.plant[plant.Y_TEMPERATURE] = m.ambient_temperature
        self.plant[plant.Y_TICK] = m.per_tick * (1.0 + 1e-6 * m.clock_ppm)
        self.counters[plant.N_SHOWN] = np.floor(position / m.pulse)
        self.counters[plant.N_NI] = -self.counters[plant.N_SHOWN]
        self.counters[plant.N_UNO] = -self.counters[plant.N_SHOWN]
        self.states, self.parameters = np.array(composition.state0, float), np.zeros(len(composition.parameters))
        self.table = table_of(self.specimen)
        self.static = np.isin(np.arange(self.parameters.size), composition.static).astype(float)
        start = force_at_rest(self.specimen, position)
        self.plant[[plant.Y_FORCE, plant.Y_CELL]] = start
        self.past = np.full(DELAYED, start)

    def _use_chip(self, program: str | Path, elf: str | Path) -> None:
        """Put the firmware's binary in the place of its model."""
        if foreign := sorted({fault.kind for fault in self.faults} & OF_THE_MODEL):
            raise InputError(f"only the firmware's model knows the fault {', '.join(foreign)}; leave the binary out")
        mark = self.constants.mark + int(self.counters[plant.N_UNO])
        self.twin = ChipFirmware(Chip(program, elf, mark))
        try:
            self.advance_to(self.time + START_UP)
        except BaseException:
            self.close()
            raise

    # requests of the host

    @property
    def time(self) -> float:
        """s, simulated."""
        return self.counters.item(plant.N_STEP) * self.constants.dt  # asked for at every step of the host

    @property
    def sampling(self) -> bool:
        """Whether the sampled task runs."""
        return self._task is not None

    @contextmanager
    def at_one_time(self) -> Iterator[None]:
        """Requests between which no time passes, in real time, too, and no request of another thread comes."""
        yield

    def serial(self, data: bytes) -> bytes:
        """Bytes from the host -> the bytes of the Uno's reply; both take their time on the line, uneven."""
        line = self.settings.uno
        latency = float(self.line_rng.uniform(line.shortest_latency, line.longest_latency))
        there = latency * float(self.line_rng.uniform())
        self._let_pass(there)
        with self.at_one_time():
            self._apply_faults()
            if self._active_fault("unplugged-serial"):
                return b""
            if isinstance(self.twin, Twin):
                reply = self.twin.receive(self._transmit(data))
            else:
                reply = self.twin.exchange(self._transmit(data), lambda: self.advance_to(self.time + 1e-3))
            self.truth_log.record_state(self.time, self.twin)
            reply = self._transmit(reply)
        self._let_pass(latency - there)
        return reply

    def _let_pass(self, seconds: float) -> None:
        """Let so much time pass while a request is on the line."""
        self.advance_to(self.time + seconds)

    def start(self, rate: float) -> None:
        """Start the sampled task: the inputs and the counter on one clock of ``rate`` Hz, first sample one period from now."""
        if self._task is not None:
            raise InputError("the sampled task runs already; stop it first")
        if not 0.0 < rate <= 250000.0:
            raise InputError(f"rate = {rate:g} Hz is not allowed; it must be greater than 0 and at most 250000")
        self.counters[plant.N_NI] = -self.counters[plant.N_SHOWN]
        self._task, self._index_taken = SampledTask(self.time, 1.0 / rate), int(self.counters[plant.N_LATCHED])

    def stop(self) -> None:
        """Stop the sampled task, if one runs; samples not read are lost."""
        self._task = None

    def read(self, n: int) -> tuple[Array, NDArray[np.int64]]:
        """The next ``n`` samples, volts (channels, n) and counts (n,), counted from where the task was started.

        Advances the clock until they exist. Channels: the rig's ``inputs``, in their order. BoardError as the board gives it.
        """
        task = self._task
        if task is None:
            raise InputError("no sampled task runs; start it first")
        if n < 1:
            raise InputError(f"n = {n} samples; read at least 1")
        done = task.taken - self.waiting
        patience = self.time + n * task.period if self._active_fault("board-timeout") else 0.0
        self.advance_to(max(task.start + (done + n) * task.period, patience))
        self._apply_board_faults(task)
        assert task.volts is not None
        assert task.counts is not None
        volts, counts = task.volts[:, :n], task.counts[:n]
        task.volts, task.counts = task.volts[:, n:], task.counts[n:]
        return volts, counts

    def read_now(self) -> tuple[Array, int]:
        """Volts (channels,) and the count of now, without a clock and without moving it; BoardError as for `read`."""
        self._apply_faults()
        self._apply_board_faults(SampledTask(self.time, 1.0))
        cell_faults = self._cell_faults()
        readings = self.plant[[plant.Y_CELL, plant.Y_COIL, plant.Y_CURRENT]].reshape(3, 1)
        volts = self._volts(SampledTask(self.time, 0.0), readings, *cell_faults)
        return volts[:, 0], int(self.counters[plant.N_SHOWN] + self.counters[plant.N_NI])

    def _apply_board_faults(self, task: SampledTask) -> None:
        """Raise the error, or wait, as the board's active faults demand of a read."""
        if self._active_fault("board-timeout"):
            raise BoardError(TIMEOUT)
        if self._active_fault("board-overrun") or self.waiting * task.period > BUFFER:
            raise BoardError(OVERRUN)
        late = self._active_fault("late-samples")
        if late is not None:
            self.delay_read(late.size)

    def index_counts(self) -> NDArray[np.int64]:
        """The board's counts at the passes of the encoder's index since the last call, at most `plant.LATCHES` of them."""
        last = int(self.counters[plant.N_LATCHED])
        first = max(self._index_taken, last - plant.LATCHES)
        self._index_taken = last
        return self.counters[plant.N_LATCH + np.arange(first, last) % plant.LATCHES].copy()

    @property
    def waiting(self) -> int:
        """The number of samples not read yet."""
        return 0 if self._task is None or self._task.counts is None else self._task.counts.size

    def queue(self, volts: Array) -> None:
        """Append to the timed command; BoardError where there is none, or it has run out."""
        if self.timed is None or self.timed.empty(self.time):
            raise BoardError(UNDERFLOW)
        self.timed.queue(volts)

    def write(self, volts: float) -> None:
        """The command voltage, now; BoardError beyond the board's range."""
        self._commanded = volts
        self.plant[plant.Y_COMMAND] = command_of(self.settings, volts)

    def switch_shunt(self, on: bool) -> None:
        """The relay that puts a shunt across the load cell's bridge, where one is wired.

        Its step is that of the volts which the rig's settings promise: what `load_cell.scale` really is shows in it.
        """
        cell = self.settings.load_cell
        self._relay = shunt_force(cell, cell.shunt) if on and self.settings.wires.shunt else 0.0
        self._set_shunt()

    def _set_shunt(self) -> None:
        fault = self._active_fault("shunted-cell")
        self.fault_flags[plant.Z_SHUNT] = self._relay + self._hand.force + (0.0 if fault is None else fault.size)

    def lay_hand_on(self, hand: Hand) -> None:
        """From now on a person does this at the table; ``Hand()``: nothing any more."""
        self._hand = hand
        self.fault_flags[[plant.Z_TURNED, plant.Z_FINGER]] = hand.speed, hand.switch
        self.fault_flags[plant.Z_PRESSED] = hand.pressed or self._active_fault("emergency-stop") is not None
        self._set_shunt()

    def write_later(self, volts: float, latency: float) -> None:
        """The command voltage, ``latency`` s from now: of a supply that is slow; it takes the place of the one before."""
        self.timed = TimedCommand(self.time, 1.0 / latency, np.array([volts]))

    @property
    def command(self) -> float:
        """The command voltage that the board holds, V."""
        return float(self.plant[plant.Y_COMMAND])

    def run_unattended(self, seconds: float) -> None:
        """Advance the clock without a host."""
        self.advance_to(self.time + seconds)

    def close(self) -> None:
        """End the program that runs the firmware's binary, if one does."""
        if isinstance(self.twin, ChipFirmware):
            self.twin.chip.close()

    # ground truth

    @property
    def truth(self) -> Truth:
        """The true quantities, once a millisecond."""
        return self.truth_log.truth()

    @property
    def at_rest_since(self) -> float:
        """The time since which the table has been at rest, s; NaN while it moves."""
        return self.truth_log.at_rest_since

    @property
    def coil_dead_since(self) -> float:
        """The time since which the coil has had no voltage and less than 10 mA, s; NaN while it has."""
        return self.truth_log.coil_dead_since

    # the clock

    def advance_to(self, time: float) -> None:
        """Advance the clock to ``time``, s; samples are buffered where the task runs."""
        last = int(np.ceil(time / self.constants.dt - 1e-6))
        while self.counters[plant.N_STEP] < last:
            self._apply_faults()
            until = min(last, self._next_change_step(), int(self.counters[plant.N_STEP]) + 100000)
            if isinstance(self.twin, Twin):
                self._advance(until)
            else:
                self._advance_with_chip(self.twin, until)
            value = None if self.timed is None else self.timed.due(self.time)
            if value is not None and value != self._commanded:
                self.write(value)
        self._apply_faults()

    def _advance_with_chip(self, firmware: ChipFirmware, until: int) -> None:
        """Steps to the end of the chip's millisecond at most; the model, which is compiled with the plant, does not count."""
        due = self.plant[plant.Y_TICK]
        end = min(until, int(np.ceil(due - 1e-6)))
        firmware.show()
        self._advance(end)
        if self.plant[plant.Y_TICK] != due:
            inputs = plant.open_inputs(self.constants, self.plant, self.fault_flags)
            firmware.tick(int(self.counters[plant.N_SHOWN] + self.counters[plant.N_UNO]), inputs)

    def _advance(self, until: int) -> None:
        """Steps during which no fault begins or ends."""
        begin, task = int(self.counters[plant.N_STEP]), self._task
        start, period, due = (0.0, 1.0, 0) if task is None else (task.start, task.period, self._due(task, until))
        start += 0.0 if task is None else task.taken * task.period
        readings, counts = np.empty((3, due)), np.empty(due, np.int64)
        rows = np.empty(((until // self.constants.per_tick) - (begin // self.constants.per_tick), len(plant.TRUTH)))
        self.counters[plant.N_TAKEN] = 0
        cell_faults, duty = self._cell_faults(), float(self.twin.registers[R_DUTY])
        arrays = (self.states, self.parameters, self.table, self.static, self.past, self.twin.registers)
        self._kernel(
            until,
            self.constants,
            self.plant,
            self.counters,
            self.fault_flags,
            *arrays,
            start,
            period,
            readings,
            counts,
            rows,
        )
        if isinstance(self.twin, ChipFirmware):  # the model has written its own
            rows[:, plant.TRUTH.index("duty")] = duty
        self.truth_log.add(rows)
        if task is not None and due:
            taken = self.counters[plant.N_TAKEN]
            volts = self._volts(task, readings[:, :taken], *cell_faults)
            task.taken += int(taken)
            task.volts = volts if task.volts is None else np.concatenate((task.volts, volts), axis=1)
            task.counts = counts[:taken] if task.counts is None else np.concatenate((task.counts, counts[:taken]))

    def _due(self, task: SampledTask, until: int) -> int:
        """The number of samples of ``task`` in the steps up to ``until``, or one more."""
        last = (until * self.constants.dt - task.start) / task.period
        return max(0, int(np.floor(last + 1e-6)) - task.taken)

    def _cell_faults(self) -> tuple[FaultSpec | None, ...]:
        """The active faults of the load cell, as `_volts` takes them."""
        return tuple(map(self._active_fault, CELL_FAULTS))

    def _volts(
        self,
        task: SampledTask,
        readings: Array,
        broken: FaultSpec | None,
        drifting: FaultSpec | None,
        inverted: FaultSpec | None,
        clipped: FaultSpec | None,
        gain: FaultSpec | None,
        slow: FaultSpec | None,
    ) -> Array:
        """The analogue inputs (channels, n) of samples with these filtered forces [N], coil voltages and currents."""
        forces, settings = readings[0], self.settings
        noise = self.settings.load_cell.noise * self.noise_rng.standard_normal(forces.size)
        noisy = forces + (noise if slow is None else self._slowed(noise, slow.size, task.period))
        noisy += self._wander_samples(forces.size, task.period)
        if drifting is not None:
            time = task.start + (task.taken + 1 + np.arange(forces.size)) * task.period
            noisy += drifting.size * (time - drifting.at)
        if inverted is not None:
            noisy = -noisy
        if gain is not None:
            noisy = gain.size * noisy
        if clipped is not None:  # what saturates is the last stage: its ends have none of the cell's noise
            noisy = np.clip(noisy, -clipped.size, clipped.size)
        volts = volts_of_force(self.settings, noisy)
        if broken is not None:
            volts = np.full_like(volts, broken.size)
        rows = {
            "force": volts,
            "temperature": np.full_like(volts, self._shown_temperature / DEGREES_PER_VOLT),
            "coil_voltage": readings[1] / settings.supply.voltage_scale,
            "coil_current": readings[2] / settings.supply.current_scale,
        }
        return converted(settings, np.stack([rows[name] for name in settings.inputs]))

    @property
    def _shown_temperature(self) -> float:
        """degC that the thermocouple shows."""
        if self._active_fault("thermocouple-stuck") is not None:
            return self._stuck_temperature
        return float(self.plant[plant.Y_TEMPERATURE])

    def _slowed(self, noise: Array, bandwidth: float, period: float) -> Array:
        """What an amplifier of ``bandwidth`` Hz lets through of the noise at its input."""
        from scipy.signal import lfilter

        decay = np.exp(-2.0 * np.pi * bandwidth * period)
        rows, _ = lfilter([1.0 - decay], [1.0, -decay], noise, zi=[decay * self._slow_noise])
        self._slow_noise = float(rows[-1]) if noise.size else self._slow_noise
        return np.asarray(rows)

    def _wander_samples(self, n: int, period: float) -> Array:
        """Slow errors of the load cell: an Ornstein-Uhlenbeck process, stationary from the start."""
        from scipy.signal import lfilter

        decay = np.exp(-period / WANDER_TIME)
        pushes = self.settings.load_cell.wander * np.sqrt(1.0 - decay**2) * self.wander_rng.standard_normal(n)
        rows, _ = lfilter([1.0], [1.0, -decay], pushes, zi=[decay * self._wander])
        self._wander = float(rows[-1]) if n else self._wander
        return np.asarray(rows)

    def _on_heartbeat(self) -> None:
        """Advance the clock while nothing is sampled."""
        if self._task is None:
            self.run_unattended(self.heartbeat_interval)

    # faults

    def _active_fault(self, *kinds: str) -> FaultSpec | None:
        """The active fault of one of these kinds."""
        if not self.faults:
            return None
        now = self.time + 1e-9
        return next((f for f in self.faults if f.kind in kinds and f.at <= now < f.until), None)

    def _next_change_step(self) -> int:
        """The step at which the next fault begins or ends."""
        command = np.inf if self.timed is None else self.timed.next_change(self.time, self._commanded)
        changes = [command] + [
            time for fault in self.faults for time in (fault.at, fault.until) if time > self.time + 1e-9
        ]
        finite = [time for time in changes if np.isfinite(time)]
        return int(np.ceil(min(finite) / self.constants.dt - 1e-6)) if finite else np.iinfo(np.int64).max

    def _apply_faults(self) -> None:
        """Set the flags of the active faults, and apply once those that act once."""
        if not self.faults:
            return
        self.fault_flags[plant.Z_STALLED] = self._active_fault("stalled-motor") is not None
        self.fault_flags[plant.Z_UNO] = self._active_fault("stuck-encoder", "stuck-encoder-uno") is not None
        self.fault_flags[plant.Z_NI] = self._active_fault("stuck-encoder", "stuck-encoder-board") is not None
        self.fault_flags[plant.Z_GLITCH] = self._active_fault("glitching-encoder") is not None
        self.fault_flags[plant.Z_SWAPPED] = self._active_fault("swapped-encoder") is not None
        self.fault_flags[plant.Z_PRESSED] = self._hand.pressed or self._active_fault("emergency-stop") is not None
        self.fault_flags[plant.Z_DEAD] = self._active_fault("dead-supply") is not None
        self.fault_flags[plant.Z_OPEN] = self._active_fault("open-coil") is not None
        slower = self._active_fault("uno-clock")
        self.fault_flags[plant.Z_CLOCK] = 0.0 if slower is None else slower.size
        self._set_shunt()
        slow, supply = self._active_fault("cell-slow"), self._active_fault("supply-gain")
        self.fault_flags[plant.Z_SLOW] = 0.0 if slow is None else 2.0 * np.pi * slow.size
        self.fault_flags[plant.Z_LACKS] = 0.0 if supply is None else 1.0 - supply.size
        self.fault_flags[plant.Z_STUCK] = self._active_fault("supply-stuck") is not None
        for fault in self.faults:
            if fault not in self._started_faults and fault.at <= self.time + 1e-9:
                if fault.kind == "supply-stuck":
                    self.fault_flags[plant.Z_STANDS] = self.constants.gain * self.plant[plant.Y_COMMAND]
                if fault.kind == "thermocouple-stuck":
                    self._stuck_temperature = float(self.plant[plant.Y_TEMPERATURE])
                self._started_faults.add(fault)
                self.truth_log.report(self.time, f"fault {fault}")
                if fault.kind == "hot-specimen":
                    self.plant[plant.Y_TEMPERATURE] += fault.size
                if fault.kind == "restarted-uno":
                    assert isinstance(self.twin, Twin)
                    self.twin.restart()
                if fault.kind == "slipped-encoder":
                    self.counters[[plant.N_UNO, plant.N_NI]] += round(fault.size / self.constants.pulse)

    def _transmit(self, data: bytes) -> bytes:
        """The bytes that arrive at the other end of the serial wire."""
        lost = self._active_fault("lost-bytes")
        if lost is None:
            return data
        return bytes(
            byte for byte, draw in zip(data, self.loss_rng.random(len(data)), strict=True) if draw >= lost.size
        )


def parse_faults(texts: Iterable[str]) -> tuple[FaultSpec, ...]:
    """Faults as typed."""
    return tuple(map(FaultSpec.parse, texts))
