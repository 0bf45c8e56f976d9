"""Which samples of a record are scored: from the time when its unknown past is forgotten to its end, or a given window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.records import Record, cycle_bounds
from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.smoothing import comparable, force_average

Array = NDArray[np.float64]
SETTLING = 2.0  # s after the motion starts: the unknown past is forgotten by then
MIN_SCORED = 8  # samples: fewer make no loop
SCORED_SHARE = 0.25  # of the motion: where settling leaves less, what is scored does not stand for the record


@dataclass(frozen=True)
class Window:
    """The samples that a score was computed on."""

    first: int
    last: int
    start: float
    end: float

    @property
    def slice(self) -> slice:
        """As an index."""
        return slice(self.first, self.last + 1)


def scoring_window(record: Record, settling: float = SETTLING, window: tuple[float, float] | None = None) -> Window:
    """The samples from ``settling`` s after the motion starts, or those between the two times of ``window``.

    Of a force that went through a moving average which is not undone, only those with whole windows.
    """
    if window is None and (reason := too_short(record, settling)):
        raise InputError(f"{record.name}: {reason}")
    start, end = window or (motion_start(record) + settling, float(record.time[-1]))
    whole = comparable(record)
    inside = np.flatnonzero((record.time >= start - 1e-9) & (record.time <= end + 1e-9))
    inside = inside[(inside >= whole.start) & (inside < whole.stop)]
    if inside.size < MIN_SCORED:
        raise InputError(
            f"{record.name}: the window {start:.3g} to {end:.3g} s holds {inside.size} samples; the record ends at "
            f"{record.time[-1]:.3g} s, so give another window=(from, to)"
        )
    return Window(int(inside[0]), int(inside[-1]), float(record.time[inside[0]]), float(record.time[inside[-1]]))


def too_short(record: Record, settling: float = SETTLING) -> str:
    """Why ``settling`` s leave too little of a record to be scored, in words; empty where they do not."""
    start, average = motion_start(record), force_average(record)
    first, end = start, float(record.time[-1])
    if average is not None:
        whole = comparable(record)
        if whole.stop - whole.start < MIN_SCORED:
            return (
                f"its force is smoothed over {average.window:.3g} s, and its {record.n} samples hold "
                f"{whole.stop - whole.start} with a whole window; give a longer record"
            )
        first, end = max(start, float(record.time[whole.start])), float(record.time[whole.stop - 1])
    motion = end - first
    remaining = end - max(start + settling, first)
    enough = max(SCORED_SHARE * motion, MIN_SCORED * record.dt)
    if remaining >= enough:
        return ""
    limit = max(end - start - enough, 0.0)
    lasts = "lasts" if average is None else f"less what its moving average of {average.window:.3g} s leaves out lasts"
    return (
        f"its motion {lasts} {motion:.3g} s and settling takes the first {settling:g} s of it, so {max(remaining, 0.0):.2g} s "
        f"({max(int(remaining / record.dt), 0)} samples) would stand for the whole; give a settling of at most "
        f"{0.95 * limit:.2g} s or a window=(from, to)"
    )


def list_unscorable(records: Sequence[Record], settling: float = SETTLING) -> dict[str, str]:
    """The records that cannot be scored, and why; :class:`~dampyr.errors.InputError` where none can."""
    reasons = {record.name: reason for record in records if (reason := too_short(record, settling))}
    if reasons and len(reasons) == len(records):
        name, reason = next(iter(reasons.items()))
        raise InputError(f"no record is long enough to be scored; {name}: {reason}")
    return reasons


def whole_cycles(record: Record, where: Window) -> tuple[slice, int] | None:
    """The samples of the whole cycles in a window, and how many cycles these are; None where there is none."""
    spans = [(a, b) for a, b in cycle_bounds(record) if a >= where.first and b <= where.last]
    return (slice(spans[0][0], spans[-1][1] + 1), len(spans)) if spans else None


def loop_work(force: Array, displacement: Array) -> np.float64:
    """The work on the damper in J along a motion, of force and displacement (n,) less their means: an offset does none."""
    return np.float64(np.trapezoid(force - np.mean(force), displacement - np.mean(displacement)))
