r"""The amplitudes that a channel is made of, by frequency.

With a Hann window :math:`h` over the N samples of the motion, resampled to even steps,

.. math:: A_k = \\frac{2}{\\sum h_n} \\left| \\sum_n h_n (y_n - \\bar y) e^{-2\\pi i k n / N} \\right|

so that a sine of amplitude A on a line of the spectrum stands there as A.
"""

from __future__ import annotations

import numpy as np

from dampyr.errors import InputError
from dampyr.records.checks.quality import motion_start
from dampyr.records.record import MIN_SAMPLES, Array, Record

CHANNELS = ("displacement", "force", "velocity")


def spectrum(record: Record, channel: str = "force") -> tuple[Array, Array]:
    """Frequencies [Hz] and amplitudes of a channel in its SI unit, from the start of the motion to the end, (m,) each.

    The lines are one over that duration apart; a Hann window spreads each over its neighbours. Raises InputError for a channel
    that the record does not have.
    """
    values = getattr(record, channel, None) if channel in CHANNELS else None
    if values is None:
        raise InputError(f"{record.name} has no {channel}; choose from {', '.join(CHANNELS)} where it is recorded")
    first = int(np.searchsorted(record.time, motion_start(record)))
    part = slice(first if record.n - first >= MIN_SAMPLES else 0, record.n)
    count = round(float(record.time[-1] - record.time[part][0]) / record.dt) + 1
    even = record.time[part][0] + record.dt * np.arange(count)
    resampled = np.interp(even, record.time[part], values[part])
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
    amplitudes: Array = 2.0 / np.sum(window) * np.abs(np.fft.rfft(window * (resampled - np.mean(resampled))))
    frequencies = np.arange(len(amplitudes)) / (count * record.dt)
    return frequencies, amplitudes
