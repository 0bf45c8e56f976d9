"""Validation of the simulated rig against the original one: its open-loop drive, and the characteristics of its records.

The original rig followed no position. Its duty rose and fell evenly, one way and the other: in its records the period is twice
the top of the duty times 2.2 or 4.2 ms, plus 0.1 s, and the peak speed goes with the top. So amplitude and shape of the motion
are the machine's own: they show the actuator's speed, how it gives way under load, and the damper.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count, pairwise

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.origin import SIMULATED
from dampyr.records import Record
from dampyr.rig.drive import DutyReversals
from dampyr.rig.firmware.protocol import VERSION, Reader, Reason, Reply, Request, SerialFrame, encode
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.simulator import Simulator

Array = NDArray[np.float64]
HARMONICS = 7  # the second to the seventh are compared
MOVED = 1e-4  # m from where the table rested
SETTLING = 1.0  # s after the motion starts: about the first cycle, left out
RATE = 100.0  # samples/s, as the original rig's
DURATION = 15.0  # s of a record
BLOCK = 0.04  # s between heartbeats: the default block of a rig


@dataclass(frozen=True)
class Characteristics:
    """Characteristics of a record of the open-loop drive, SI; harmonics are of the displacement, over its fundamental.

    ``period`` s, ``stroke`` m from turn to turn (of the fundamental), ``peak_speed`` m/s a cycle's mean of them, ``third`` and
    ``others`` (2nd and 4th to 7th, the largest), ``mean_force`` N over whole cycles, ``force_span`` N from the 2nd to the 98th
    percentile, ``force_step`` N and ``displacement_step`` m the smallest steps between values, ``drift`` m/s of the middle.
    """

    period: float
    stroke: float
    peak_speed: float
    third: float
    others: float
    mean_force: float
    force_span: float
    force_step: float
    displacement_step: float
    drift: float


def characteristics(record: Record) -> Characteristics:
    """The `Characteristics` of a record, measured or simulated; InputError where it has fewer than three whole cycles."""
    t, x, force = record.time, record.displacement, record.force
    start = int(np.argmax(np.abs(x - x[0]) > MOVED))
    settled = t >= t[start] + SETTLING
    rises = _rise_times(t[settled], x[settled])
    if rises.size < 4:
        raise InputError(f"{record.name}: {max(0, rises.size - 1)} whole cycles after the start; at least 3 are needed")
    cycles = settled & (t >= rises[0]) & (t < rises[-1])
    period = float(np.diff(rises).mean())
    drift = _drift_of_means(t, x, rises)
    sizes = _harmonics(t[cycles], x[cycles] - drift * t[cycles], period)
    relative = sizes / sizes[0]
    return Characteristics(
        period=period,
        stroke=float(2 * sizes[0]),
        peak_speed=_peak_speed(t, x, rises),
        third=float(relative[2]),
        others=float(np.delete(relative, (0, 2)).max()),
        mean_force=float(force[cycles].mean()),
        force_span=float(np.subtract(*np.percentile(force[cycles], (98, 2)))),
        force_step=_step(force),
        displacement_step=_step(x),
        drift=drift,
    )


def _rise_times(t: Array, x: Array) -> Array:
    """The times at which the displacement rises through its mean line."""
    level = x - np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyfit(t, x, 1))
    k = np.flatnonzero((level[:-1] < 0) & (level[1:] >= 0))
    return np.asarray(t[k] - level[k] * (t[k + 1] - t[k]) / (level[k + 1] - level[k]))


def _drift_of_means(t: Array, x: Array, rises: Array) -> float:
    """The drift of a cycle's mean, m/s; a line through the samples themselves would be biased by the sine's phase."""
    ends = list(pairwise(rises))
    means = [x[(t >= a) & (t < b)].mean() for a, b in ends]
    return float(np.polynomial.polynomial.polyfit([0.5 * (a + b) for a, b in ends], means, 1)[1])


def _harmonics(t: Array, x: Array, period: float) -> Array:
    """Amplitudes of the first harmonics over whole cycles."""
    turns = 2j * np.pi * (t - t[0]) / period
    return np.array([abs(2 * np.mean(x * np.exp(-n * turns))) for n in range(1, HARMONICS + 1)])


def _peak_speed(t: Array, x: Array, rises: Array) -> float:
    """Mean over cycles of the largest speed, the derivative taken over 20 ms and its noise averaged over three samples."""
    speed = np.abs(np.convolve(np.gradient(x, t), np.ones(3) / 3, "same"))
    ends = pairwise(rises)
    return float(np.mean([speed[(t >= a) & (t < b)].max() for a, b in ends]))


def _step(values: Array) -> float:
    """The smallest step between two values that occur; one of rounding does not count."""
    steps = np.diff(np.unique(values))
    steps = steps[steps > 1e-6 * np.ptp(values)]
    return float(np.median(steps[steps < 1.5 * steps.min()]))


def open_loop(settings: RigSettings, drive: DutyReversals, voltage: float) -> Record:
    """A record of the simulated rig as the original took them: at rest for a second, then reversals, 100 samples a second.

    ``voltage`` at the coil. The table starts where its strokes are centred; a first run determines that position. The
    force is volts times the load cell's scale: its zero is not taken out.
    """
    first = _record_from(settings, drive, voltage, -0.008, 4.0).displacement
    half = first[first.size // 2 :]
    start = -0.008 - 0.5 * float(half.min() + half.max())
    return _record_from(settings, drive, voltage, start, DURATION)


def _record_from(settings: RigSettings, drive: DutyReversals, voltage: float, start: float, seconds: float) -> Record:
    """A record that begins ``start`` m from the middle."""
    rig = Simulator(settings, position=start)
    ask, start_count = _request_sender(rig), int(np.floor(start / settings.encoder.count))
    _arm(settings, ask, start_count)
    rig.write(voltage / settings.supply.gain)
    rig.start(RATE)
    blocks = [_read_block(rig, ask) for _ in range(round(1.0 / BLOCK))]
    ask(Request.REVERSE, round(255 * drive.duty), round(drive.half_period * 1e3), round(drive.pause * 1e3), 65535)
    blocks += [_read_block(rig, ask) for _ in range(round((seconds - 1.0) / BLOCK))]
    volts, counts = np.concatenate([v[0] for v, _ in blocks]), np.concatenate([c for _, c in blocks])
    return Record(
        time=np.arange(volts.size) / RATE,
        displacement=(counts + start_count) * settings.encoder.count,
        force=volts * settings.load_cell.scale,
        voltage=voltage,
        name=f"simulated, {voltage:g} V, top {round(255 * drive.duty)}",
        origin=SIMULATED,
    )


def _arm(settings: RigSettings, ask: Callable[..., None], position: int) -> None:
    """Arm a table that stands at ``position`` [counts], within half of its encoder: the open loop itself keeps to no stroke."""
    count = settings.encoder.count
    half, fastest = round(0.5 * settings.encoder.range / count), round(settings.limits.speed / count)
    ask(Request.HELLO, VERSION)
    ask(Request.CLEAR)
    ask(Request.LIMITS, -half, half, fastest, 200, 255, 1000, 0, 255, 0)
    ask(Request.HOME, 0, position)
    ask(Request.HEARTBEAT)
    ask(Request.ARM)


def _request_sender(rig: Simulator) -> Callable[..., None]:
    """A function that sends a request; InputError where the rig refuses it."""
    reader, numbers = Reader(), count()

    def ask(kind: Request, *values: int) -> None:
        (reply,) = reader.feed(rig.serial(encode(SerialFrame(kind, next(numbers) % 256, values))))
        if reply.kind is Reply.NAK:
            raise InputError(f"the rig refuses {kind.name} {values}: {Reason(reply.values[1]).name}; change the drive")

    return ask


def _read_block(rig: Simulator, ask: Callable[..., None]) -> tuple[Array, NDArray[np.int64]]:
    """A block of samples, and a heartbeat."""
    samples = rig.read(max(1, round(BLOCK * RATE)))
    ask(Request.HEARTBEAT)
    return samples
