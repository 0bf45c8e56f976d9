"""Rest before the motion: when does the table start to move?"""

from __future__ import annotations

import numpy as np

from dampyr.records.cycles import legs
from dampyr.records.record import Array, Record

EXCURSION = 0.1


def motion_start(record: Record) -> float:
    """The time, s, of the last sample at rest; the first sample's time where the record starts moving.

    The first excursion of a tenth of the median distance between turning points is motion for certain; from
    there the search goes back to the last sample that is still at the rest level, which is within 1.5 encoder
    steps or four standard deviations of the displacement's noise, whichever is wider. A record that never
    moves starts at its end.
    """
    x = record.displacement
    size = _size(record)
    away = np.flatnonzero(np.abs(x - x[0]) > EXCURSION * size)
    if size == 0 or len(away) == 0:
        return float(record.time[-1])
    return float(record.time[_last_at_rest(x, int(away[0]))])


def _size(record: Record) -> float:
    lengths = np.abs(legs(record))
    return float(np.median(lengths)) if len(lengths) else float(np.ptp(record.displacement))


def _last_at_rest(x: Array, away: int) -> int:
    near = rest_tolerance(x)
    level = x[0]
    for _ in range(2):
        at_rest = np.flatnonzero(np.abs(x[:away] - level) <= near)
        if len(at_rest) == 0:
            return 0
        level = float(np.median(x[: at_rest[-1] + 1]))
    return int(at_rest[-1])


def rest_tolerance(x: Array) -> float:
    """How far a displacement at rest strays, m: 1.5 quantisation steps or 4 deviations of the noise.

    The noise comes from third differences (variance 20 times its own), which hold next to nothing of the
    motion.
    """
    from dampyr.records.quality import quantum

    spread = np.median(np.abs(np.diff(x, 3))) / (0.6745 * np.sqrt(20.0))
    step = quantum(x)
    return max(1.5 * (step or 0.0), 4.0 * float(spread), 1e-9 * float(np.ptp(x)))
