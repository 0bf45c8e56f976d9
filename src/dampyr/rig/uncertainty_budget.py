r"""Standard uncertainty of what a rig measures, a budget per channel (JCGM 100:2008).

Each part is one sigma in the channel's unit. What grows with the force or the voltage is that of their largest value in the
record; what grows with the force's rate, or with changes of the voltage, that of its root mean square. A limit that is never
passed, +-a, counts as :math:`a/\sqrt{3}`, a step q of a converter or an encoder as :math:`q/\sqrt{12}`. What was measured by
`dampyr calibrate` stands with its own uncertainty, what the settings assume with theirs. What a test itself has shown
goes in as well: counts that were lost, the shift of the force's zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.models.numerics.differentiation import differentiate
from dampyr.rig.interlock import Samples
from dampyr.rig.settings import RigSettings
from dampyr.rig.shunt import SHUNT_UNCERTAINTY, ShuntStep, expected_step
from dampyr.rig.slow_passes import SlowPass
from dampyr.rig.thermal_model import COLD, COPPER, THERMOCOUPLE

Array = NDArray[np.float64]
UNSEEN_COUNTS = 2.0  # that the board and the Uno may differ by at rest, where no index shows them
STRETCH = 0.2  # s: a count in it is a speed of 25 um/s
UNSEEN_DRIFT = 10.0  # N by which the force's zero may have moved where it was not looked at
WARMING = 0.3  # of the warming that the thermal model gives: its heat capacity and cooling are assumed


@dataclass(frozen=True)
class Evidence:
    """What a test has shown of its own measurement. "First", "before" and "after" are the slow passes (`ArmedRig.verify`)."""

    lost_counts: float | None = None
    """Counts of the encoder that were lost; None where no index shows them."""
    zero_shift: tuple[float, float] | None = None
    """N by which the force's zero, before and after, is off the first; None where it was not looked at."""
    first_mean: float = 0.0
    """N, the mean force of the first pass."""
    expected_mean: float | None = None
    """N, what the damper's card promises of it; None without a card."""
    heights: tuple[float, float, float] | None = None
    """N, half of the damper's hysteresis: first, before and after."""
    noise: float = math.nan
    """V rms, the load cell's noise from sample to sample on the first pass; NaN where it tells nothing."""
    compared: tuple[SlowPass, SlowPass] | None = None
    """A slow pass by those that are kept of earlier runs with the same specimen, and the first of this run; None without."""
    shunts: tuple[ShuntStep, ...] = ()
    """Steps of the shunt across the load cell's bridge: first, before and after; none without one."""
    temperature: float = COLD
    """degC of the damper after the test."""
    warming: float = 0.0
    """K by which that is above the room's."""
    rise: float = 0.0
    """K by which it rose in the test."""
    command_delay: float = 0.0
    """s by which a change of the voltage may be late, as of a supply without the samples' clock."""
    parted: float = 0.0
    """K by which the thermocouple is above the estimate (`dampyr.rig.thermal_model.Warmth`)."""
    doubt: str = ""
    """What seems to be wrong with the thermocouple."""


class LostCounts:
    """Counts of the encoder that were lost in a test, as the index and the Uno's count show them; a watcher of blocks."""

    def __init__(self, count: float) -> None:
        self._count, self._passes, self._apart, self._still = count, set[int](), 0.0, False

    def __call__(self, samples: Samples) -> None:
        """Take a block."""
        self._passes.update(samples.index.tolist())
        still = samples.status.speed == 0 and int(np.ptp(samples.counts)) == 0
        if still and self._still and samples.status.homed:
            position = round(float(samples.displacement[-1]) / self._count - 0.5)
            self._apart = max(self._apart, abs(position - samples.status.position))
        self._still = still

    def number(self, index: Mapping[int, int]) -> float | None:
        """The most that one of them shows, with ``index`` as in `dampyr.rig.interlock.Interlock`; None where the board sees
        none."""
        edges = [place for key, place in index.items() if key]
        if not edges or not self._passes:
            return None
        return max(self._apart, *(min(abs(place - edge) for edge in edges) for place in self._passes))


class Sizes:
    """The largest force [N] and voltage [V] of a record that comes in pieces, the force's rate, and the voltage's
    changes; ``late`` is the number of samples by which it may be late."""

    def __init__(self, bandwidth: float, late: int = 0) -> None:
        self.bandwidth, self.late, self.force, self.voltage = bandwidth, late, 0.0, 0.0
        self._n, self._sum, self._changes = 0, 0.0, 0.0
        self.speeds: list[float] = []
        """The mean speed of each stretch of `STRETCH` in which the table moves, m/s."""

    def add(self, time: Array, displacement: Array, force: Array, voltage: Array | float) -> None:
        """A piece, (n,) SI each."""
        n = max(1, round(STRETCH * (len(time) - 1) / float(time[-1] - time[0])))
        moved = np.abs(displacement[n::n] - displacement[:-n:n])
        self.speeds += (moved[moved > 0.0] / STRETCH).tolist()
        self._n += len(time)
        self._sum += float(np.sum(differentiate(time, force, self.bandwidth) ** 2))
        if self.late and np.ndim(voltage):
            self._changes += float(np.sum((np.asarray(voltage)[self.late :] - np.asarray(voltage)[: -self.late]) ** 2))
        self.force = max(self.force, float(np.abs(force).max()))
        self.voltage = max(self.voltage, float(np.abs(voltage).max()))

    @property
    def rate(self) -> float:
        """The root of the mean square of the force's rate, N/s: its peaks are those of a few samples at reversals."""
        return math.sqrt(self._sum / max(1, self._n))

    @property
    def change(self) -> float:
        """The root of the mean square of the voltage's change within the time by which it may be late, V."""
        return math.sqrt(self._changes / max(1, self._n))


def budget(
    rig: RigSettings, evidence: Evidence, duration: float, pieces: Iterable[tuple[Array, Array, Array, Array | float]]
) -> dict[str, dict[str, float]]:
    """The parts of each channel's standard uncertainty; ``pieces`` are time, displacement, force and voltage of a record
    in turn.
    """
    late = math.ceil(evidence.command_delay * rig.board.rate)
    sizes = Sizes(rig.board.velocity_bandwidth, late)
    for piece in pieces:
        sizes.add(*piece)
    parts = {
        "time": {"clock": rig.board.clock_accuracy * duration / math.sqrt(3.0)},
        "displacement": _displacement(rig, evidence),
        "velocity": {"resolution of the encoder": _counting_noise(rig, np.array(sizes.speeds), 1)},
        "force": _force(rig, evidence, sizes),
        "voltage": _voltage(rig, evidence, sizes),
    }
    if "temperature" in rig.inputs:
        certified = rig.certificates.standard("thermocouple")
        parts["temperature"] = {
            "thermocouple": THERMOCOUPLE if certified is None else certified,
            "distance from the estimate": abs(evidence.parted) / math.sqrt(3.0),
        }
    return parts


def _displacement(rig: RigSettings, evidence: Evidence) -> dict[str, float]:
    count = rig.encoder.count
    lost = UNSEEN_COUNTS if evidence.lost_counts is None else evidence.lost_counts
    return {
        "resolution of the encoder": count / math.sqrt(12.0),
        "accuracy of the scale": rig.encoder.accuracy / math.sqrt(3.0),
        "lost counts": lost * count / math.sqrt(3.0),
    }


def _counting_noise(rig: RigSettings, speeds: Array, order: int) -> float:
    r"""The noise of counting in the velocity [m/s rms], or at ``order`` 2 in the acceleration [m/s2 rms], with the
    response H(f) of `dampyr.models.numerics.differentiation` at the record's bandwidth,
    for a table that goes at ``speeds`` [m/s] in turn.

    At an even speed the reading is a sawtooth of a count q about the position, at the counts per second less the next multiple
    of the sampling rate, :math:`f_b`: where the two beat slowly, all of it is within the bandwidth,
    :math:`\sigma_v^2 = \sum_k \frac{q^2}{2 \pi^2 k^2} |H(k f_b)|^2`. It is no less than that of noise which is new with each
    sample, :math:`\frac{q^2}{12} \int |H|^2`, for no motion is quite even.
    """
    rate, count = rig.board.rate, rig.encoder.count
    time = np.arange(round(20.0 / rig.board.velocity_bandwidth * rate)) / rate
    impulse = np.zeros(len(time))
    impulse[len(time) // 2] = 1.0
    response = impulse
    for _ in range(order):
        response = differentiate(time, response, rig.board.velocity_bandwidth)
    white = count**2 / 12.0 * float(np.sum(response**2))
    if not speeds.size:
        return math.sqrt(white)
    known, gain = np.fft.rfftfreq(8 * len(time), 1.0 / rate), np.abs(np.fft.rfft(response, 8 * len(time)))
    beat = speeds / count - rate * np.round(speeds / count / rate)
    harmonics = np.arange(1, 65)[:, None]
    at = harmonics * np.abs(beat)
    sizes = np.where(at < 0.5 * rate, np.interp(at, known, gain), 0.0) * count / (math.pi * harmonics)
    return math.sqrt(float(np.mean(np.maximum(0.5 * np.sum(sizes**2, axis=0), white))))


def _force(rig: RigSettings, evidence: Evidence, sizes: Sizes) -> dict[str, float]:
    cell = rig.load_cell
    if evidence.zero_shift is None:
        shift = UNSEEN_DRIFT / math.sqrt(3.0)
    else:
        before, after = evidence.zero_shift
        shift = math.sqrt((before**2 + before * after + after**2) / 3.0)  # it went from one to the other in the test
    return {
        "scale": cell.scale_uncertainty * sizes.force,
        "zero": cell.zero_uncertainty,
        "shift of the zero": shift,
        "linearity and hysteresis": slow_errors(rig),
        "noise": cell.noise,
        "converter": rig.step * abs(cell.scale) / math.sqrt(12.0),
        "delay of the amplifier": cell.delay_uncertainty * sizes.rate,
        **({"inertia": cell.mass * _counting_noise(rig, np.array(sizes.speeds), 2)} if cell.mass else {}),
    }


def slow_errors(rig: RigSettings) -> float:
    """N of the load cell by its linearity and its hysteresis, which a mean over some seconds does not lessen."""
    return math.sqrt(2.0 / 3.0) * rig.load_cell.linearity * rig.load_cell.capacity


def shunt_error(rig: RigSettings) -> float:
    """The standard uncertainty [N] with which the step of the shunt is expected: the shunt's, the scale's, the cell's own."""
    relative = math.hypot(SHUNT_UNCERTAINTY, rig.load_cell.scale_uncertainty)
    return abs(expected_step(rig)) * relative + slow_errors(rig)


def _voltage(rig: RigSettings, evidence: Evidence, sizes: Sizes) -> dict[str, float]:
    supply, volts = rig.supply, sizes.voltage
    read = "coil_voltage" in rig.inputs
    # the coil may be as warm as estimated where the thermocouple reads something else
    kelvin = math.hypot(WARMING * evidence.warming, evidence.parted / math.sqrt(3.0))
    warm = COPPER * kelvin * volts if supply.compensated else 0.0
    return {
        ("reading" if read else "gain of the supply"): (supply.reading_uncertainty if read else supply.gain_uncertainty)
        * volts,
        "resistance of the coil": supply.resistance_uncertainty * volts,
        "warmth of the coil": warm,
        # a step is late by half of that on the average, where it is late at all
        **({"delay of the supply": sizes.change / math.sqrt(2.0)} if evidence.command_delay and not read else {}),
        "converter": rig.step * (supply.voltage_scale if read else supply.gain) / math.sqrt(12.0),
    }
