"""What kind of motion a record holds: a sine, a sweep, or something broader."""

from __future__ import annotations

import numpy as np

from dampyr.records.checks.overview import repeats
from dampyr.records.cycle_analysis.cycles import turning_points
from dampyr.records.record import Record

SWEPT = 2.0  # an octave: a sweep covers more, a sine whose frequency drifts far less
RANK = 0.8  # rank correlation of order and duration: a random motion of six legs or more rarely has it


def waveform(record: Record) -> str:
    """``"sine"``, ``"sweep"`` or ``"random"``, from the displacement.

    It is a sweep where the durations between turning points rise or fall all along (rank correlation beyond 0.8) by a factor
    of 2 or more from the first third to the last; a sine where the motion repeats itself (`dampyr.records.overview`), however
    distorted; else random, as an earthquake is.
    """
    if _swept(record):
        return "sweep"
    return "sine" if repeats(record) else "random"


def _swept(record: Record) -> bool:
    from scipy.stats import spearmanr

    lasting = np.diff(record.time[turning_points(record)])
    if lasting.size < 6:
        return False
    rank = spearmanr(np.arange(lasting.size), lasting).statistic
    third = lasting.size // 3
    first, last = float(np.median(lasting[:third])), float(np.median(lasting[-third:]))
    return bool(abs(rank) > RANK and max(first / last, last / first) >= SWEPT)
