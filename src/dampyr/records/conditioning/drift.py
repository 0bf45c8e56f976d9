"""Drift of the mean position: reported, and removed only when asked."""

from __future__ import annotations

import numpy as np

from dampyr.records.cycle_analysis.cycles import mean_over_time, require_cycles
from dampyr.records.record import Array, Record


def mean_positions(record: Record) -> tuple[Array, Array]:
    """Times (s) and mean positions (m) of the whole cycles, ``(cycles,)`` each."""
    spans = require_cycles(record, "the drift")
    at = np.array([0.5 * (record.time[i0] + record.time[i1]) for i0, i1 in spans])
    return at, np.array([mean_over_time(record.displacement, record, i0, i1) for i0, i1 in spans])


def drift(record: Record) -> float:
    """The drift of the mean position, m/s: the slope of the least-squares line through the cycles' means.

    One cycle alone shows its drift as the distance between its two equal turning points over its duration.
    """
    at, mean = mean_positions(record)
    if len(at) == 1:
        i0, i1 = require_cycles(record, "the drift")[0]
        moved = record.displacement[i1] - record.displacement[i0]
        return float(moved / (record.time[i1] - record.time[i0]))
    return float(np.polyfit(at - at.mean(), mean, 1)[0])
