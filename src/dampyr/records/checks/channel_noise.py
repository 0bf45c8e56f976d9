"""The steps and the noise of a channel, and how far it strays at rest."""

from __future__ import annotations

import numpy as np

from dampyr.records.record import Array


def quantum(values: Array) -> float | None:
    """The quantisation step of a channel in its own unit, or None when the values are continuous.

    Levels that differ by float noise are one level. The step is the smallest distance between levels, taken
    when at least 95 % of the distances are whole multiples of it to 5 %, and then refined over the whole
    span.
    """
    span = float(np.ptp(values))
    apart = np.diff(np.unique(values))
    apart = apart[apart > 1e-9 * max(span, float(np.max(np.abs(values))))]
    if len(apart) < 4:
        return None
    step = float(np.min(apart))
    whole = np.rint(apart / step)
    if np.mean(np.abs(apart / step - whole) < 0.05) < 0.95:
        return None
    return float(np.sum(apart) / np.sum(whole))


def rest_tolerance(x: Array) -> float:
    """How far a displacement at rest strays, m: 1.5 quantisation steps or 4 deviations of the noise.

    The noise comes from third differences (variance 20 times its own), which hold next to nothing of the
    motion.
    """
    # 0.6745: the median of |z| of a normal distribution
    spread = np.median(np.abs(np.diff(x, 3))) / (0.6745 * np.sqrt(20.0))
    step = quantum(x)
    return max(1.5 * (step or 0.0), 4.0 * float(spread), 1e-9 * float(np.ptp(x)))


def last_at_rest(x: Array, away: int) -> int:
    """The last sample before ``away`` that is still at the level at which ``x`` begins, 0 where there is none."""
    near = rest_tolerance(x)
    level = x[0]
    for _ in range(2):  # the first sample has noise, too: the second round starts from the median of the rest
        at_rest = np.flatnonzero(np.abs(x[:away] - level) <= near)
        if len(at_rest) == 0:
            return 0
        level = float(np.median(x[: at_rest[-1] + 1]))
    return int(at_rest[-1])
