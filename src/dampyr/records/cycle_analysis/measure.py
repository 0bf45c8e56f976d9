r"""What a record measures: frequency, amplitude, harmonics, drift, energy; never taken from a label.

Over the whole cycles the displacement is fitted by least squares with

.. math:: x(t) = p_0 + p_1 t + p_2 t^2 + \sum_{k=1}^{7} a_k \cos 2\pi k f t + b_k \sin 2\pi k f t

where f is found with Gauss-Newton from the cycles' mean duration. Over one cycle alone, trend and harmonics are too much alike
to tell its frequency: that is one over its duration then.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dampyr.errors import InputError
from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.drift import drift
from dampyr.records.conditioning.force_offset import mean_force
from dampyr.records.conditioning.velocity import default_bandwidth, differentiate
from dampyr.records.cycle_analysis.cycles import require_cycles
from dampyr.records.record import Array, Record
from dampyr.records.record_cache import cached_by_record
from dampyr.shown import Shown

ORDERS = 7  # harmonics of the motion: those of a distorted sine fall off, and higher ones lie in the noise


@dataclass(frozen=True, repr=False)
class Measured(Shown):
    """What was measured over the whole cycles of a record, SI.

    Attributes
    ----------
    frequency_hz, peak_to_peak_m
        Of the motion; peak to peak per cycle (the mean of a cycle's way up and way down, median over cycles),
        which a drift of the mean position does not widen.
    mean_force, drift_m_per_s, peak_speed, energy_per_cycle
        N; m/s; m/s; J dissipated per cycle (median; negative when the loops create energy).
    harmonics
        Amplitude of the orders 2 to 7 over the fundamental's.
    distortion
        What is left of the displacement by the fit above, rms over the fundamental's rms.
    cycles, motion_start
        How many whole cycles, and when the motion starts, s.
    """

    frequency_hz: float
    peak_to_peak_m: float
    mean_force: float
    drift_m_per_s: float
    peak_speed: float
    energy_per_cycle: float
    harmonics: Mapping[int, float]
    distortion: float
    cycles: int
    motion_start: float

    @property
    def total_harmonic_distortion(self) -> float:
        """The root of the sum of the squares of `harmonics`: of the orders 2 to 7, over the fundamental."""
        return float(np.sqrt(sum(amplitude**2 for amplitude in self.harmonics.values())))


def measure(record: Record) -> Measured:
    """Measure the motion and the loops of a record over its whole cycles.

    Raises
    ------
    InputError
        There is no whole cycle.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> x = 0.008 * np.sin(2 * np.pi * t)
    >>> record = dp.records.Record(t, x, damper.force(t, x, voltage=1.98), voltage=1.98)
    >>> measured = dp.records.measure(record)
    >>> print(f"{measured.frequency_hz:.4g} Hz, {1e3 * measured.peak_to_peak_m:.4g} mm, {measured.energy_per_cycle:.4g} J")
    1 Hz, 16 mm, 15.32 J
    >>> measured.cycles
    3
    """
    spans = require_cycles(record, "a measurement")
    frequency, amplitudes, distortion = _harmonics(record, spans)
    part = slice(spans[0][0], spans[-1][1] + 1)
    speed = differentiate(record.time, record.displacement, default_bandwidth(record))
    return Measured(
        frequency_hz=frequency,
        peak_to_peak_m=peak_to_peak(record, spans),
        mean_force=mean_force(record),
        drift_m_per_s=drift(record),
        peak_speed=float(np.max(np.abs(speed[part]))),
        energy_per_cycle=float(np.median(cycle_energies(record, spans))),
        harmonics={k: float(amplitudes[k - 1] / amplitudes[0]) for k in range(2, ORDERS + 1)},
        distortion=distortion,
        cycles=len(spans),
        motion_start=motion_start(record),
    )


@cached_by_record
def fundamental(record: Record) -> tuple[float, float]:
    """The frequency in Hz and the distortion of :class:`Measured`, without the rest; an InputError without a whole cycle."""
    frequency, _, distortion = _harmonics(record, require_cycles(record, "a measurement"))
    return frequency, distortion


def total_harmonic_distortion(record: Record) -> float:
    r"""The total harmonic distortion of a record's displacement over its whole cycles:
    :math:`\sqrt{A_2^2 + \ldots + A_7^2} / A_1`.

    :class:`~dampyr.errors.InputError` without a whole cycle.
    """
    return measure(record).total_harmonic_distortion


def amplitude_error(record: Record) -> float:
    """By how much the amplitude of a record's fundamental over its whole cycles is larger than its label says, of the label's.

    :class:`~dampyr.errors.InputError` without a whole cycle, or without a label.
    """
    if record.label is None or not record.label.peak_to_peak_m:
        raise InputError(f"{record.name} has no label that says its peak to peak; give it one, or use `measure`")
    _, amplitudes, _ = _harmonics(record, require_cycles(record, "an amplitude"))
    return float(2.0 * amplitudes[0] / record.label.peak_to_peak_m - 1.0)


def peak_to_peak(record: Record, cycles: list[tuple[int, int]]) -> float:
    """Peak to peak per cycle, m: the mean of the way up and the way down, median over the cycles."""
    return float(np.median([_half_travel(record.displacement[i0 : i1 + 1]) for i0, i1 in cycles]))


def cycle_energies(record: Record, cycles: list[tuple[int, int]]) -> Array:
    """The energy dissipated in each cycle, J: the loop integral of force by displacement, by trapezoids.

    The mean force is left out, so that gas force times drift is not counted.
    """
    force = record.force - mean_force(record)
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(record.displacement)
    return np.array([float(np.sum(work[i0:i1])) for i0, i1 in cycles])


def _half_travel(x: Array) -> float:
    """Half the way there and back of a cycle that runs from one turning point to its next equal."""
    far = x[np.argmax(np.abs(x - 0.5 * (x[0] + x[-1])))]
    return float(0.5 * (abs(far - x[0]) + abs(far - x[-1])))


def _harmonics(record: Record, spans: list[tuple[int, int]]) -> tuple[float, Array, float]:
    """``(frequency, amplitudes of orders 1 to 7, distortion)`` of the displacement over the whole cycles."""
    part = slice(spans[0][0], spans[-1][1] + 1)
    middle = 0.5 * (record.time[part.start] + record.time[part.stop - 1])
    t, x = record.time[part] - middle, record.displacement[part]
    frequency = len(spans) / float(t[-1] - t[0])
    for _ in range(8 if len(spans) > 1 else 0):  # converges in two or three
        basis, slope, coefficients = _fit(t, x, frequency)
        size = float(np.linalg.norm(slope)) or 1.0
        step = float(_solve(np.column_stack([basis, slope / size]), x)[-1]) / size
        frequency += step  # Gauss-Newton: the last column is the slope of the fitted curve by the frequency
        if abs(step) < 1e-10 * frequency:
            break
    basis, _, coefficients = _fit(t, x, frequency)
    amplitudes = np.hypot(coefficients[3 : 3 + ORDERS], coefficients[3 + ORDERS :])
    left = float(np.sqrt(np.mean((x - basis @ coefficients) ** 2)))
    return frequency, amplitudes, left / float(amplitudes[0] / np.sqrt(2.0))  # both rms


def _solve(basis: Array, x: Array) -> Array:
    """Least squares by the normal equations; the columns are of one size."""
    # small sums: a threaded product would wait longer for its threads than it computes
    normal = np.einsum("ni,nj->ij", basis, basis)
    return np.linalg.lstsq(normal, np.einsum("ni,n->i", basis, x), rcond=None)[0]


def _fit(t: Array, x: Array, frequency: float) -> tuple[Array, Array, Array]:
    """The basis ``(n, 17)``, the fitted curve's derivative by frequency ``(n,)``, the coefficients."""
    orders = 2.0 * np.pi * np.arange(1, ORDERS + 1)
    phase = orders * frequency * t[:, None]
    cos, sin = np.cos(phase), np.sin(phase)
    scaled = t / max(float(np.max(np.abs(t))), 1e-300)
    basis = np.column_stack([scaled**0, scaled, scaled**2, cos, sin])
    coefficients = _solve(basis, x)
    a, b = coefficients[3 : 3 + ORDERS], coefficients[3 + ORDERS :]
    slope = t * ((cos * orders) @ b - (sin * orders) @ a)
    return basis, slope, coefficients
