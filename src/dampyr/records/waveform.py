"""What kind of motion a record holds: a sine, a sweep, or something broader."""

from __future__ import annotations

import numpy as np

from dampyr.records.cycles import turning_points
from dampyr.records.record import Record

KINDS = ("sine", "sweep", "random")
SINE = 0.8
HARMONICS = 5
BESIDE = 0.15
SWEPT = 2.0


def waveform(record: Record) -> str:
    """``"sine"``, ``"sweep"`` or ``"random"``, from the displacement.

    A sine has 80 % or more of its variance within 15 % of the strongest frequency and its multiples up to the fifth, the
    straight line through the displacement taken off: a distorted sine counts as one. Otherwise it is a sweep where the
    durations between turning points rise or fall all along (rank correlation beyond 0.8) by a factor of 2 or more, else random,
    as an earthquake is.
    """
    x = record.displacement
    x = x - np.polyval(np.polyfit(record.time - record.time[0], x, 1), record.time - record.time[0])
    even = np.interp(np.linspace(record.time[0], record.time[-1], record.n), record.time, x)
    power = np.abs(np.fft.rfft(even * np.hanning(record.n))) ** 2
    frequency = np.fft.rfftfreq(record.n)
    power[0] = 0.0
    strongest = frequency[int(np.argmax(power))]
    beside = np.zeros(power.size, dtype=bool)
    for k in range(1, HARMONICS + 1):
        beside |= np.abs(frequency - k * strongest) <= max(BESIDE * strongest, 3.0 / record.n)
    if power[beside].sum() >= SINE * power.sum():
        return "sine"
    return "sweep" if _swept(record) else "random"


def _swept(record: Record) -> bool:
    from scipy.stats import spearmanr

    lasting = np.diff(record.time[turning_points(record)])
    if lasting.size < 6:
        return False
    rank = spearmanr(np.arange(lasting.size), lasting).statistic
    third = lasting.size // 3
    first, last = float(np.median(lasting[:third])), float(np.median(lasting[-third:]))
    return abs(rank) > 0.8 and max(first / last, last / first) >= SWEPT
