"""Whether the fitted records hold the motion of what is to be predicted: stroke and speed per reversal.

A motion is parted at its turning points. Each part, from one turning point to the next, has a stroke (m) and a mean speed
(m/s). Friction and hysteresis at a stroke or a speed below all that was measured are extrapolated, which no score on full-size
sines can see: an earthquake spends much of its time in small, slow reversals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.records import Record
from dampyr.records.checks.channel_noise import rest_tolerance
from dampyr.records.cycle_analysis.cycles import turning_points

Array = NDArray[np.float64]
SMALLEST = 0.005  # of the whole stroke: smaller reversals move a damper by less than its clevis gives way
NOISE = 2.0  # times the displacement's noise: below it a reversal may be none


@dataclass(frozen=True)
class Strokes:
    """The parts of a motion between turning points: strokes in m, mean speeds in m/s and durations in s, each (k,)."""

    stroke: Array
    speed: Array
    duration: Array


def reversals(record: Record) -> Strokes:
    """The parts of a record's motion between its turning points, but for those that noise may have made."""
    x = record.displacement
    threshold = max(NOISE * rest_tolerance(x), SMALLEST * float(np.ptp(x)))
    points = turning_points(record, threshold) if threshold > 0.0 else np.empty(0, dtype=int)
    stroke, duration = np.abs(np.diff(x[points])), np.diff(record.time[points])
    return Strokes(stroke, stroke / duration, duration)


def list_motions_beyond(
    fitted: Sequence[Record], planned: Sequence[Record], thresholds: FitThresholds | None = None
) -> dict[str, str]:
    """The planned motions that are smaller or slower than the fitted records for more than a tenth of their time
    (``outside_time``), each with a sentence that says how much, and what to record."""
    limits = thresholds or FitThresholds()
    if not planned:
        return {}
    measured = [strokes for strokes in map(reversals, fitted) if strokes.stroke.size]
    if not measured:
        return {}
    least_stroke = min(float(np.median(strokes.stroke)) for strokes in measured)
    least_speed = min(float(np.median(strokes.speed)) for strokes in measured)
    notes = {}
    for record in planned:
        moved = reversals(record)
        if not moved.stroke.size:
            continue
        small, slow = (
            moved.stroke < limits.outside_margin * least_stroke,
            moved.speed < limits.outside_margin * least_speed,
        )
        total = float(moved.duration.sum())
        shares = [float(moved.duration[where].sum()) / total for where in (small, slow)]
        if max(shares) <= limits.outside_time:
            continue
        where = small if shares[0] > limits.outside_time else slow
        stroke, speed = (1e3 * float(np.median(quantity[where])) for quantity in (moved.stroke, moved.speed))
        notes[record.name] = (
            f"{record.name} moves for {100 * shares[0]:.0f} % of its time in reversals smaller than all that was fitted "
            f"({1e3 * least_stroke:.3g} mm), for {100 * shares[1]:.0f} % slower ({1e3 * least_speed:.3g} mm/s): its force "
            f"there is extrapolated; record sines of about {stroke:.2g} mm peak to peak at {speed:.2g} mm/s mean speed too"
        )
    return notes
