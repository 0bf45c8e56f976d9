"""Turning points and whole cycles, found without a window picked by hand.

A turning point counts when the motion goes back from it by more than a threshold (a zigzag with hysteresis),
so neither the plateaus of a quantised encoder, nor noise, nor a harmonic's ripple makes one; a drift of the
mean position moves none.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.records.record import Array, Record

FRACTION_OF_LEG = 0.25  # a reversal smaller than this part of a leg is noise or a stop, no turning point
FIRST_FRACTION_OF_RANGE = 0.05  # to start from: below any leg that matters, above the noise of an encoder
LIKE_THE_OTHERS = 0.7  # of the median: run-up and run-down differ by more, whole cycles of a test by less
_cache: WeakKeyDictionary[Record, NDArray[np.int64]] = (
    WeakKeyDictionary()
)  # records never change, and every package needs their cycles


def turning_points(record: Record, threshold: float | None = None) -> NDArray[np.int64]:
    """Sample numbers ``(m,)`` at which the displacement turns round, in order.

    A turning point is the middle of the extreme plateau between two moves of more than ``threshold`` (m) in
    opposite directions. By default the threshold is a quarter of the median distance between turning points.
    Rest before the motion and the ends of the record are none.
    """
    if threshold is not None:
        if not threshold > 0:
            raise InputError(f"threshold = {threshold:g} m is not allowed; it must be greater than 0")
        return _zigzag(record.displacement, threshold)
    if record not in _cache:
        own = _threshold(record.displacement)
        _cache[record] = _zigzag(record.displacement, own) if own > 0 else np.zeros(0, dtype=np.int64)
        _cache[record].setflags(write=False)
    return _cache[record]


def legs(record: Record) -> Array:
    """Distances ``(m - 1,)`` in m from each turning point to the next, positive upwards."""
    return np.diff(record.displacement[turning_points(record)])


def cycles(record: Record) -> list[tuple[int, int]]:
    """Index ranges ``[i0, i1)`` of the whole cycles after the motion starts, between turning points.

    Cycles of the run-in and of the stop, whose legs or duration differ by more than 30 % from the median
    cycle's, are left out at both ends; those in between are kept, so the ranges follow on one another. Of the
    two ways to cut (upper or lower turning points) the one with more cycles is taken, the earlier one when
    they are equal. An empty list says that there is no whole cycle.
    """
    points = turning_points(record)
    cuts = [_like_the_others(record, points[first:]) for first in (0, 1)]
    return max(cuts, key=len)


def _threshold(x: Array) -> float:
    """A quarter of the median leg, started from one twentieth of the whole range."""
    threshold = FIRST_FRACTION_OF_RANGE * float(np.ptp(x))
    for _ in range(3):
        if threshold == 0:
            return 0.0
        points = _zigzag(x, threshold)
        if len(points) < 2:
            return threshold
        threshold = FRACTION_OF_LEG * float(np.median(np.abs(np.diff(x[points]))))
    return threshold


def _zigzag(x: Array, threshold: float) -> NDArray[np.int64]:
    values = x.tolist()
    points: list[int] = []
    low = high = 0
    direction = 0
    for i in _extremes(x):
        value = values[i]
        if value > values[high]:
            high = i
        if value < values[low]:
            low = i
        if direction >= 0 and values[high] - value > threshold:
            if direction > 0:
                points.append(_plateau_middle(values, high, i))
            direction, low, high = -1, i, i
        elif direction <= 0 and value - values[low] > threshold:
            if direction < 0:
                points.append(_plateau_middle(values, low, i))
            direction, low, high = 1, i, i
    return np.array(points, dtype=np.int64)


def _extremes(x: Array) -> list[int]:
    """The samples at which the displacement is highest or lowest among its neighbours, the first of each plateau: a leg in
    between turns nowhere."""
    moves = np.diff(x)
    moving = np.flatnonzero(moves)
    if not moving.size:
        return [0]
    rising = moves[moving] > 0.0
    turns = np.append(np.flatnonzero(rising[1:] != rising[:-1]), moving.size - 1)
    return [0, *(moving[turns] + 1).tolist()]


def _plateau_middle(values: list[float], first: int, end: int) -> int:
    """The middle of the samples of ``values[first:end]`` that stand at ``values[first]``, to float noise."""
    level = values[first]
    noise = 1e-9 * (abs(level) + abs(level - values[end]))
    last = max(i for i in range(first, end) if abs(values[i] - level) <= noise)
    return (first + last) // 2


def _like_the_others(record: Record, points: NDArray[np.int64]) -> list[tuple[int, int]]:
    edges = points[::2]
    whole = len(edges) - 1
    if whole < 1:
        return []
    x = record.displacement[points]
    span = np.abs(np.diff(x))[: 2 * whole].reshape(whole, 2)
    lasting = np.diff(record.time[edges])
    alike = np.all(span > LIKE_THE_OTHERS * np.median(span), axis=1)
    alike &= np.all(span * LIKE_THE_OTHERS < np.median(span), axis=1)
    alike &= (lasting > LIKE_THE_OTHERS * np.median(lasting)) & (lasting * LIKE_THE_OTHERS < np.median(lasting))
    indices = np.flatnonzero(alike)
    if len(indices) == 0:
        return []
    return [(int(edges[k]), int(edges[k + 1])) for k in range(indices[0], indices[-1] + 1)]


def require_cycles(record: Record, purpose: str) -> list[tuple[int, int]]:
    """The whole cycles, or an :class:`InputError` that says what needs them."""
    spans = cycles(record)
    if not spans:
        raise InputError(
            f"{record.name}: no whole cycle in {record.duration:g} s, and {purpose} needs one; "
            "give a record with at least three turning points"
        )
    return spans


def whole(record: Record, purpose: str) -> slice:
    """The samples of all whole cycles together."""
    spans = require_cycles(record, purpose)
    return slice(spans[0][0], spans[-1][1])


def cycle_average(record: Record, samples: int | None = None) -> Record:
    """The mean cycle: every whole cycle resampled to the same ``samples`` phases and averaged.

    Time runs over one mean period; each channel is interpolated linearly at equal fractions of its own cycle,
    so a drift of the mean position is averaged, not removed. ``samples`` defaults to the median cycle's.
    """
    spans = require_cycles(record, "a cycle average")
    count = samples or int(np.median([i1 - i0 for i0, i1 in spans]))
    if count < 8:
        raise InputError(f"samples = {count} is too few for a cycle; give at least 8")
    phases = np.arange(count) / count

    def mean(values: Any) -> Any:
        if values is None or isinstance(values, float):
            return values
        return np.mean([_at_phases(values, i0, i1, record.time, phases) for i0, i1 in spans], axis=0)

    period = float(record.time[spans[-1][1]] - record.time[spans[0][0]]) / len(spans)
    channels = ("displacement", "force", "velocity", "voltage", "current", "temperature")
    changed = {name: mean(getattr(record, name)) for name in channels}
    note = f"averaged over {len(spans)} whole cycles of {period:.4f} s at {count} phases"
    return record.replace(note=note, time=period * phases, **changed)


def _at_phases(values: Array, i0: int, i1: int, time: Array, phases: Array) -> Array:
    at = time[i0] + phases * (time[i1] - time[i0])
    return np.interp(at, time[i0 : i1 + 1], values[i0 : i1 + 1])
