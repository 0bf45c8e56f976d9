r"""The amplitudes that a channel is made of, by frequency.

With a Hann window :math:`h` over the N samples of the motion, resampled to even steps,

.. math:: A_k = \\frac{2}{\\sum h_n} \\left| \\sum_n h_n (y_n - \\bar y) e^{-2\\pi i k n / N} \\right|

so that a sine of amplitude A on a line of the spectrum stands there as A.

`repeated_spectrum` leaves the run-in and the tapers out. Where the motion repeats itself it takes the whole cycles of full
amplitude, each resampled to as many samples, without a window: the excitation and its multiples then lie on lines of the
spectrum, whatever the cycles' own scatter. Any other motion is averaged as [Welch1967]_ has it, over segments of a third.

References
----------
.. [Welch1967] P. D. Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Transactions on Audio
   and Electroacoustics 15(2), 70-73, 1967.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dampyr.errors import InputError
from dampyr.phrases import counted
from dampyr.records.checks.overview import repeats
from dampyr.records.checks.quality import motion_start
from dampyr.records.cycle_analysis.cycles import cycle_bounds
from dampyr.records.record import MIN_SAMPLES, Array, Record

HARMONICS = 15  # of the excitation, that are told
SEGMENTS = 3  # of a motion that does not repeat itself; each overlaps the next by half
CHANNELS = ("displacement", "force", "velocity")


def spectrum(record: Record, channel: str = "force") -> tuple[Array, Array]:
    """Frequencies [Hz] and amplitudes of a channel in its SI unit, from the start of the motion to the end, (m,) each.

    The lines are one over that duration apart; a Hann window spreads each over its neighbours. Raises InputError for a channel
    that the record does not have.
    """
    resampled = _motion(record, _channel(record, channel))
    amplitudes = _amplitudes(resampled, 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(resampled.size) / resampled.size))
    return np.arange(len(amplitudes)) / (resampled.size * record.dt), amplitudes


@dataclass(frozen=True)
class RepeatedSpectrum:
    """Frequencies, Hz, and amplitudes in the channel's SI unit, (m,) each; ``of`` says of which part of the record.

    ``excitation`` is the frequency of the whole cycles, Hz, None where the motion does not repeat itself, and ``cycles`` how
    many they are: the line of number ``cycles`` is the excitation's.
    """

    frequencies: Array
    amplitudes: Array
    of: str
    excitation: float | None = None
    cycles: int = 0

    def harmonics(self) -> list[dict[str, float]]:
        """Number, frequency and amplitude of the excitation, number 1, and of its multiples."""
        lines = range(self.cycles, min((HARMONICS + 1) * self.cycles, len(self.amplitudes)), self.cycles or 1)
        return [
            {
                "number": k // self.cycles,
                "frequency": float(self.frequencies[k]),
                "amplitude": float(self.amplitudes[k]),
            }
            for k in lines
        ]


def repeated_spectrum(record: Record, channel: str = "force") -> RepeatedSpectrum:
    """The spectrum of the whole cycles of full amplitude, or of a motion without any the average over its segments.

    Raises InputError as `spectrum` does.
    """
    from scipy.signal import welch

    values, spans = _channel(record, channel), cycle_bounds(record)
    if spans and repeats(record):
        count = max(int(np.median([i1 - i0 for i0, i1 in spans])), 4)
        phases = np.arange(count) / count
        at = np.concatenate([record.time[i0] + phases * (record.time[i1] - record.time[i0]) for i0, i1 in spans])
        amplitudes = _amplitudes(np.interp(at, record.time, values), np.ones(at.size))
        excitation = len(spans) / float(record.time[spans[-1][1]] - record.time[spans[0][0]])
        frequencies = np.arange(len(amplitudes)) * excitation / len(spans)
        return RepeatedSpectrum(frequencies, amplitudes, counted(len(spans), "whole cycle"), excitation, len(spans))
    resampled = _motion(record, values)
    size = max(resampled.size // SEGMENTS, min(resampled.size, MIN_SAMPLES))
    # powers are half of the squares of the amplitudes
    frequencies, powers = welch(resampled, 1.0 / record.dt, nperseg=size, scaling="spectrum")
    of = f"segments of {size * record.dt:.3g} s, averaged (no whole cycle repeats)"
    return RepeatedSpectrum(frequencies, np.sqrt(2.0 * powers), of)


def _channel(record: Record, channel: str) -> Array:
    values = getattr(record, channel, None) if channel in CHANNELS else None
    if values is None:
        raise InputError(f"{record.name} has no {channel}; choose from {', '.join(CHANNELS)} where it is recorded")
    return np.asarray(values)


def _motion(record: Record, values: Array) -> Array:
    """A channel from the start of the motion on, at even steps of the sampling interval."""
    first = int(np.searchsorted(record.time, motion_start(record)))
    part = slice(first if record.n - first >= MIN_SAMPLES else 0, record.n)
    count = round(float(record.time[-1] - record.time[part][0]) / record.dt) + 1
    return np.interp(record.time[part][0] + record.dt * np.arange(count), record.time[part], values[part])


def _amplitudes(values: Array, window: Array) -> Array:
    return np.asarray(2.0 / np.sum(window) * np.abs(np.fft.rfft(window * (values - np.mean(values)))))
