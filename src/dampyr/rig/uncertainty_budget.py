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
from dampyr.rig.thermal_model import COLD, COPPER, THERMOCOUPLE

Array = NDArray[np.float64]
UNSEEN_COUNTS = 2.0  # that the board and the Uno may differ by at rest, where no index shows them
UNSEEN_DRIFT = 10.0  # N by which the force's zero may have moved where it was not looked at
WARMING = 0.3  # of the warming that the thermal model gives: its heat capacity and cooling are assumed


@dataclass(frozen=True)
class Evidence:
    """What was seen in a test: counts that were lost, None where no index shows them; and the shift [N] of the force's zero
    before and after the test against the first look, None where it was not looked at; the damper's temperature [degC] after
    the test, how much that is above the room's, and how much it rose in the test; the s by which a change of the voltage
    may be late, as of a supply without the samples' clock; and the K by which the thermocouple is above the estimate, with what
    seems to be wrong with it (`dampyr.rig.thermal_model.Warmth`)."""

    lost_counts: float | None = None
    zero_shift: tuple[float, float] | None = None
    temperature: float = COLD
    warming: float = 0.0
    rise: float = 0.0
    command_delay: float = 0.0
    parted: float = 0.0
    doubt: str = ""


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
        self._n, self._sum, self._changes, self._path, self._time = 0, 0.0, 0.0, 0.0, 0.0

    def add(self, time: Array, displacement: Array, force: Array, voltage: Array | float) -> None:
        """A piece, (n,) SI each."""
        self._path += float(np.sum(np.abs(np.diff(displacement))))
        self._time += float(time[-1] - time[0])
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
    def speed(self) -> float:
        """The mean speed, m/s."""
        return self._path / self._time if self._time else 0.0

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
        "velocity": {"resolution of the encoder": _velocity_noise(rig, sizes.speed)},
        "force": _force(rig, evidence, sizes),
        "voltage": _voltage(rig, evidence, sizes),
    }
    if "temperature" in rig.inputs:
        parts["temperature"] = {
            "thermocouple": THERMOCOUPLE,
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


def _velocity_noise(rig: RigSettings, speed: float) -> float:
    r""":math:`\sigma_v^2 = \sigma_x^2 \frac{2}{f_e} \int_0^{\infty} (2 \pi f)^2 |G(f)|^2 \mathrm{d}f` of counting noise, with
    the gain of `dampyr.models.numerics.differentiation`.

    The noise is new with each count, not with each sample: it is white up to :math:`f_e/2`, where f_e is the sampling rate, or
    a quarter of the counts per second where these are fewer, for even motion beats with the sampling; twice the bandwidth at
    least.
    """
    rate, bandwidth = rig.board.rate, rig.board.velocity_bandwidth
    time = np.arange(round(20.0 / bandwidth * rate)) / rate
    impulse = np.zeros(len(time))
    impulse[len(time) // 2] = 1.0
    response = differentiate(time, impulse, bandwidth)
    independent = min(rate, max(0.25 * speed / rig.encoder.count, 2.0 * bandwidth))
    white = float(np.sqrt(np.sum(response**2)))
    return rig.encoder.count / math.sqrt(12.0) * white * math.sqrt(rate / independent)


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
        "linearity and hysteresis": math.sqrt(2.0 / 3.0) * cell.linearity * cell.capacity,
        "noise": cell.noise,
        "converter": rig.step * abs(cell.scale) / math.sqrt(12.0),
        "delay of the amplifier": cell.delay_uncertainty * sizes.rate,
    }


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
