"""The lag of the force behind the motion: estimated and reported, corrected only when asked.

What is measured without a model is the time from each zero of the velocity to the next zero of the force (its
mean over whole cycles removed). A pure delay (sensor, filter, coil) is part of it, and so is the hysteresis
itself, which needs a path to turn the force round: the lag is an upper bound of the delay. How much of it is
delay depends on the model; fit a damper with a delay part to tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dampyr.errors import InputError
from dampyr.records.conditioning.force_offset import mean_force
from dampyr.records.conditioning.velocity import default_bandwidth, differentiate
from dampyr.records.cycle_analysis.cycles import require_cycles, turning_points
from dampyr.records.record import Array, Record


@dataclass(frozen=True)
class ForceLag:
    """The lag from velocity zero to force zero, s.

    ``seconds`` is the mean of ``after_upper`` and ``after_lower``, the medians behind upper and lower turning
    points (an error of the force offset moves these two apart and leaves their mean); ``spread`` is the
    median absolute deviation about them; ``reversals`` says how many turning points were used.
    """

    seconds: float
    after_upper: float
    after_lower: float
    spread: float
    reversals: int

    def __str__(self) -> str:
        return (
            f"force zero {1e3 * self.seconds:.1f} ms after velocity zero (+-{1e3 * self.spread:.1f} ms, "
            f"{self.reversals} reversals): an upper bound of a delay, hysteresis included"
        )


def estimate_delay(record: Record) -> ForceLag:
    """The lag of the force behind the velocity over the whole cycles; the record stays as it is.

    Raises
    ------
    InputError
        There is no whole cycle, or the force does not change sign behind the turning points.
    """
    spans = require_cycles(record, "the delay")
    points = turning_points(record)
    points = points[(points >= spans[0][0]) & (points <= spans[-1][1])]
    speed = differentiate(record.time, record.displacement, default_bandwidth(record))
    force = record.force - mean_force(record)
    lags: dict[int, list[float]] = {1: [], -1: []}
    reach = int(np.median(np.diff(points)) / 2)
    for point in points:
        before, after = max(point - reach, 0), min(point + reach, record.n - 1)
        ends = record.displacement[before] + record.displacement[after]
        upper = 1 if record.displacement[point] > 0.5 * ends else -1
        lag = _lag(record.time, upper * speed, upper * force, int(point), reach)
        if lag is not None:
            lags[upper].append(lag)
    if not lags[1] or not lags[-1]:
        raise InputError(
            f"{record.name}: the force does not change sign within half a stroke of the turning points; "
            "remove its offset or check its channel"
        )
    # an offset of the force lengthens one kind of lag by what it shortens the other
    upper_lag, lower_lag = float(np.median(lags[1])), float(np.median(lags[-1]))
    apart = np.abs(np.r_[np.array(lags[1]) - upper_lag, np.array(lags[-1]) - lower_lag])
    return ForceLag(0.5 * (upper_lag + lower_lag), upper_lag, lower_lag, float(np.median(apart)), len(apart))


def correct_delay(record: Record, seconds: float) -> Record:
    """The record with the motion delayed by ``seconds`` to meet its force, which is left as it is.

    Displacement and velocity are interpolated linearly, and the first ``seconds`` (the last ones, for a
    negative delay) cut off.
    """
    if not (math.isfinite(seconds) and abs(seconds) < 0.5 * record.duration):
        raise InputError(
            f"seconds = {seconds:g} s is not a possible delay of a record of {record.duration:g} s; "
            "give less than half of its duration"
        )
    t = record.time
    indices = np.flatnonzero((t - seconds >= t[0]) & (t - seconds <= t[-1]))
    delayed = {
        name: np.interp(t[indices] - seconds, t, getattr(record, name))
        for name in ("displacement", "velocity")
        if getattr(record, name) is not None
    }
    cut = {
        name: values[indices]
        for name in ("time", "force", "voltage", "current", "temperature")
        if isinstance(values := getattr(record, name), np.ndarray)
    }
    note = f"motion delayed by {seconds:.6g} s to meet the force, {record.n - len(indices)} samples cut off"
    return record.replace(note=note, **delayed, **cut)


def _lag(time: Array, speed: Array, force: Array, point: int, reach: int) -> float | None:
    """From the zero of ``speed`` nearest to a sample to the zero of ``force`` nearest to that; both fall."""
    start, stop = max(point - reach, 0), min(point + reach, len(time))
    turns = _falls(time, speed, start, stop)
    falls = _falls(time, force, start, stop)
    if not len(turns) or not len(falls):
        return None
    turn = turns[np.argmin(np.abs(turns - time[point]))]
    return float(falls[np.argmin(np.abs(falls - turn))] - turn)


def _falls(time: Array, values: Array, start: int, stop: int) -> Array:
    """The times between two samples at which ``values`` fall through zero."""
    a, b = values[start : stop - 1], values[start + 1 : stop]
    k = np.flatnonzero((a > 0) & (b <= 0))
    at = start + k
    return time[at] + (time[at + 1] - time[at]) * a[k] / (a[k] - b[k])
