"""The one place that cuts a motion: turning points, half cycles, cycles and levels, without a window picked by hand.

A turning point counts when the motion goes back from it by more than a threshold (a zigzag with hysteresis),
so neither the plateaus of a quantised encoder, nor noise, nor a harmonic's ripple makes one; a drift of the
mean position moves none.

`cut_cycles` counts cycles as a test commands them: from the start of the motion, each to the next pass of the position at which
the motion began, in the same direction, so that three that were run are three. `cycle_bounds` gives the part of full amplitude
between turning points, over which frequency, mean force and energy per cycle are averaged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.records.checks.channel_noise import last_at_rest, rest_tolerance
from dampyr.records.record import MIN_SAMPLES, Array, Record
from dampyr.records.record_cache import cached_by_record
from dampyr.shown import Shown

Indices = NDArray[np.int64]
FRACTION_OF_LEG = 0.25  # a reversal smaller than this part of a leg is noise or a stop, no turning point
FIRST_FRACTION_OF_RANGE = 0.05  # to start from: below any leg that matters, above the noise of an encoder
LIKE_THE_OTHERS = 0.7  # of the median: run-up and run-down differ by more, whole cycles of a test by less
OF_FULL_AMPLITUDE = 0.05  # of the median leg: an end cycle that differs by more is one of a ramp ...
BEYOND_SCATTER = 6.0  # ... unless the legs differ among themselves: median absolute deviations from their median
SMALLEST_LEVEL = 0.02  # of the largest stroke: smaller motions are not counted as cycles
OVER_REST = 2.5  # times what a displacement at rest strays: legs that noise does not make
LONG_LEG = 3.0  # times the median leg's duration: it may hide a pause, or a level of small strokes
EXCURSION = 0.1  # of the way to the first turning point: motion for certain
NEARBY = 2  # legs to each side, of whose middles the median is the mean position there
STARTS_IN_THE_MIDDLE = 0.5  # of the amplitude: a motion that begins closer to its mean position is cut where it began
AT_ONCE = 0.1  # of the amplitude: what a record that begins in full motion may be away from its mean position or turning point
AT_REST = 0.03  # of a period: a record that stays longer at its first position begins with a rest
HALTED = 0.4  # of a leg's duration near its middle: there the motion pauses
NEAR_MIDDLE, AT_MIDDLE = 0.05, 0.01  # of a leg: the zone in which a pause is looked for, and its ends
HALF_LEG = 0.7  # of the leg beyond: two such legs in a row meet where one level ends in the middle and the next begins
SAME_STROKE, SAME_PERIOD = 0.1, 0.2  # relative: cycles of one level
FEWEST = 4  # samples of a cycle: three have no loop, and what passes the middle so fast is noise
# Rising strokes: so many cycles at least, the largest stroke over the smallest, and the rank correlation.
RISING, RANGE, IN_ORDER = 4, 2.0, 0.9
RUN_IN_TO = 3  # cycles of a level: single cycles that grow up to it, or fall from it, are its run-in or run-out


@dataclass(frozen=True)
class CutCycle:
    """A cycle or half cycle as it was commanded, SI.

    ``number`` counts from 1 from the start of the motion, half cycles by themselves; ``level`` is the level's number,
    0 of a cycle of the run-in or run-out. It lasts from ``start_s`` to ``stop_s``, between samples where the motion
    passes its position between them; the samples ``first`` to ``last`` lie within. ``stroke_m`` is from its lowest to
    its highest point, ``open_m`` how far its end lies from its start.
    """

    number: int
    level: int
    start_s: float
    stop_s: float
    first: int
    last: int
    stroke_m: float
    open_m: float


@dataclass(frozen=True)
class Level:
    """Successive cycles ``first`` to ``last`` (their numbers) of one stroke, m, to 10 % and one period, s, to 20 %."""

    number: int
    first: int
    last: int
    stroke_m: float
    period_s: float

    @property
    def count(self) -> int:
        """How many cycles."""
        return self.last - self.first + 1


@dataclass(frozen=True, repr=False)
class Cut(Shown):
    """A motion as it was cut.

    ``cycles`` are whole; ``half_cycles`` are those of all of them and one more where the motion ends, or pauses, half a cycle
    later. ``from_start`` is False where the record begins in full motion away from its mean position: then the count begins
    at the first pass. ``stroke_m`` is the largest distance between two turning points, or to the motion's end.
    ``begins_in_the_middle`` says that cycles are cut where the motion passes the position from which it started, not at
    turning points; before ``first_turn`` (s) the damper comes from rest.
    """

    cycles: tuple[CutCycle, ...] = ()
    half_cycles: tuple[CutCycle, ...] = ()
    levels: tuple[Level, ...] = ()
    from_start: bool = True
    stroke_m: float = 0.0
    begins_in_the_middle: bool = False
    first_turn: float = -np.inf

    @property
    def run(self) -> float:
        """How many cycles were run, in halves."""
        return 0.5 * len(self.half_cycles)

    @property
    def stepped(self) -> bool:
        """Whether this is a test of levels: two or more of different strokes or periods, which hold most of its cycles."""
        several = [level for level in self.levels if level.count > 1]
        return len(several) > 1 and sum(level.count for level in several) > 0.5 * len(self.cycles)

    @property
    def graded(self) -> bool:
        """Whether the motion was commanded with rising or falling strokes: in levels, or from cycle to cycle."""
        strokes = np.array([cycle.stroke_m for cycle in self.cycles if cycle.level])
        if self.stepped:
            return True
        if strokes.size < RISING or strokes.max() < RANGE * strokes.min():
            return False
        rank = np.argsort(np.argsort(strokes))
        return bool(abs(np.corrcoef(rank, np.arange(strokes.size))[0, 1]) > IN_ORDER)

    @property
    def repeats(self) -> bool:
        """Whether most of the cycles are like a neighbour."""
        return sum(level.count for level in self.levels if level.count > 1) > 0.5 * len(self.cycles)


@cached_by_record
def cut_cycles(record: Record) -> Cut:
    """Cut a motion into half cycles, cycles and levels, counted from its start.

    A motion that begins within half its amplitude of its mean position is cut where it passes the position from which it
    started (with a drift, moved along); one that begins at a turning point is cut at turning points; a record that begins in
    full motion at its passes of the mean position, from the first one on. A pause near the mean position belongs to no cycle.
    Levels are successive cycles of one stroke and period; single cycles that grow up to a level of three or more at the start,
    or fall from one at the end, are the run-in and run-out and have level 0. Motions below 2 % of the largest stroke are left
    out. A motion with fewer than two turning points has no cycle.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 6.0, 1201)
    >>> x = np.where(t < 3.0, 0.004, 0.008) * np.sin(2 * np.pi * t)
    >>> cut = dp.records.cut_cycles(dp.records.Record(t, x, x))
    >>> [(level.count, round(level.stroke_m, 4)) for level in cut.levels]
    [(3, 0.008), (3, 0.016)]
    """
    return cut_part(record)[0]


def cut_part(record: Record, away: float | None = None) -> tuple[Cut, float]:
    """As `cut_cycles`, and how far from the mean position the last cycles are cut, m; NaN where that is at turning points.

    With ``away``, which came with the cut of an earlier part of the same motion, a record that begins where a cycle of that
    part began is cut at the same position.
    """
    points = fine_turning_points(record)
    if len(points) < 2:
        return Cut(), np.nan
    x = record.displacement
    start, stop = _rest_ends(x, points)
    bounds = [0, *_meetings(x, points), len(points)]
    halves: list[tuple[float, float]] = []
    from_start, in_the_middle = True, False
    for k, (low, high) in enumerate(pairwise(bounds)):
        stretch = points[low:high]
        begins = start if k == 0 else _left(x, int(points[low - 1]), int(stretch[0]))
        ends = stop if high == len(points) else _reached(x, int(stretch[-1]), int(points[high]))
        edges, start_is_seen, last_away = _edges(record, stretch, begins, ends, k > 0, None if k else away)
        halves += [(a[1], b[0]) for a, b in pairwise(edges)]
        if k == 0:  # a later stretch begins where the one before it has ended
            from_start, in_the_middle = start_is_seen, not np.isnan(last_away)
    legs = np.abs(np.diff(x[np.r_[start, points, stop]]))
    stroke, first_turn = float(np.max(legs)), float(record.time[points[0]])
    return _number_cycles(record, halves, from_start, stroke, in_the_middle, first_turn), last_away


def turning_points(record: Record, threshold: float | None = None) -> Indices:
    """Sample numbers ``(m,)`` at which the displacement turns round, in order.

    A turning point is the middle of the extreme plateau between two moves of more than ``threshold`` (m) in
    opposite directions. By default the threshold is a quarter of the median distance between turning points.
    Rest before the motion and the ends of the record are none.
    """
    if threshold is not None:
        if not threshold > 0:
            raise InputError(f"threshold = {threshold:g} m is not allowed; it must be greater than 0")
        return _zigzag(record.displacement, threshold)
    return _turning_points(record)


@cached_by_record
def _turning_points(record: Record) -> Indices:
    threshold = _threshold(record.displacement)
    points = _zigzag(record.displacement, threshold) if threshold > 0 else np.zeros(0, dtype=np.int64)
    points.setflags(write=False)
    return points


def legs(record: Record) -> Array:
    """Distances ``(m - 1,)`` in m from each turning point to the next, positive upwards."""
    return np.diff(record.displacement[turning_points(record)])


def cycle_bounds(record: Record) -> list[tuple[int, int]]:
    """Index ranges ``[i0, i1)`` of the whole cycles of full amplitude, between turning points.

    Of a test of levels these are the cycles of the level with the largest stroke. Else cycles of the run-in and of the stop,
    whose legs or duration differ by more than 30 % from the median cycle's, are left out at both ends, and so are those of a
    ramp: an end cycle with a leg that differs from the median by more than 5 %, and by more than legs differ among themselves.
    Those in between are kept, so the ranges follow on one another. Of the two ways to cut (upper or lower turning points) the
    one with more cycles is taken, the earlier one when they are equal. An empty list says that there is no whole cycle.
    """
    return list(_full_cycles(record))


@cached_by_record
def _full_cycles(record: Record) -> list[tuple[int, int]]:
    spans = similar_cycles(record)
    if not spans:
        return []
    x = record.displacement
    far = [x[i0 + int(np.argmax(np.abs(x[i0 : i1 + 1] - x[i0])))] for i0, i1 in spans]
    span = np.abs([(point - x[i0], point - x[i1]) for point, (i0, i1) in zip(far, spans, strict=True)])
    apart = np.abs(span / np.median(span) - 1.0)
    ramp = np.max(apart, axis=1) > max(OF_FULL_AMPLITUDE, BEYOND_SCATTER * float(np.median(apart)))
    full = np.flatnonzero(~ramp)
    return spans[full[0] : full[-1] + 1] if full.size else spans


def similar_cycles(record: Record) -> list[tuple[int, int]]:
    """The ranges of `cycle_bounds` with those of ramps at both ends that differ by less than 30 % from the median cycle."""
    return list(_similar_cycles(record))


@cached_by_record
def _similar_cycles(record: Record) -> list[tuple[int, int]]:
    points = turning_points(record)
    cut = cut_cycles(record)
    if cut.stepped:
        largest = max(cut.levels, key=lambda level: (level.count > 1, level.stroke_m))
        start, stop = cut.cycles[largest.first - 1].first, cut.cycles[largest.last - 1].last
        points = points[(points >= start) & (points <= stop + 1)]
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


def _zigzag(x: Array, threshold: float) -> Indices:
    values = x.tolist()  # single numbers of an array are slow
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
                points.append(_plateau_middle(x, high, i))
            direction, low, high = -1, i, i
        elif direction <= 0 and value - values[low] > threshold:
            if direction < 0:
                points.append(_plateau_middle(x, low, i))
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


def _plateau_middle(x: Array, first: int, end: int) -> int:
    """The middle of the samples of ``x[first:end]`` that stand at ``x[first]``, to float noise."""
    level = x[first]
    noise = 1e-9 * (abs(level) + abs(level - x[end]))
    last = first + int(np.flatnonzero(np.abs(x[first:end] - level) <= noise)[-1])
    return (first + last) // 2


def _like_the_others(record: Record, points: Indices) -> list[tuple[int, int]]:
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


def fine_turning_points(record: Record) -> Indices:
    """The turning points, and those of levels with small strokes before, after and between them."""
    x = record.displacement
    points = turning_points(record)
    if len(points) < 2:
        return points
    leg = np.abs(np.diff(x[points]))
    noise, least = OVER_REST * rest_tolerance(x), SMALLEST_LEVEL * float(np.max(leg))
    floor, outer = max(least, noise), max(0.5 * least, noise)  # the first and the last leg of a level are half ones
    lasting = LONG_LEG * float(np.median(np.diff(record.time[points])))
    added = _turns_within(x, 0, int(points[0]), outer, FRACTION_OF_LEG * float(leg[0]))
    added += _turns_within(x, int(points[-1]), len(x) - 1, outer, FRACTION_OF_LEG * float(leg[-1]))
    for low, high in pairwise(points.tolist()):
        if record.time[high] - record.time[low] > lasting:
            added += _turns_within(x, low, high, floor)
    return np.array(sorted({*points.tolist(), *added}), dtype=np.int64) if added else points


def _turns_within(x: Array, low: int, high: int, floor: float, neighbour: float = np.inf) -> list[int]:
    """The turning points of a stretch between two others, by its own threshold of at least ``floor``; and again at its ends.

    One alone is a turning point where it is one of a leg as long as its ``neighbour``, too.
    """
    part = x[low : high + 1]
    turns = _zigzag(part, floor)
    if len(turns) > 2:
        turns = _zigzag(part, max(floor, FRACTION_OF_LEG * float(np.median(np.abs(np.diff(part[turns]))))))
    elif len(turns) == 1 and min(abs(part[turns[0]] - part[0]), abs(part[turns[0]] - part[-1])) < neighbour:
        return []
    if not len(turns):
        return []
    first, last = low + int(turns[0]), low + int(turns[-1])
    if len(turns) == 1:
        return [first]
    leg = FRACTION_OF_LEG * np.abs(np.diff(part[turns]))
    return [
        *_turns_within(x, low, first, floor, leg[0]),
        *(low + int(turn) for turn in turns),
        *_turns_within(x, last, high, floor, leg[-1]),
    ]


def _rest_ends(x: Array, points: Indices) -> tuple[int, int]:
    """The last sample at rest before the motion and the first one after it, or the record's ends."""
    noise = rest_tolerance(x)

    def start(values: Array, first: int) -> int:
        away = np.abs(values[: first + 1] - values[0])
        return last_at_rest(values, int(np.argmax(away > max(EXCURSION * away[-1], min(noise, 0.5 * away[-1])))))

    return start(x, int(points[0])), len(x) - 1 - start(x[::-1], len(x) - 1 - int(points[-1]))


def _meetings(x: Array, points: Indices) -> list[int]:
    """The turning points, by their places, at which one level ends in the middle and the next begins the other way."""
    leg = np.abs(np.diff(x[points]))
    inner = range(2, len(points) - 2)
    return [k for k in inner if leg[k - 1] < HALF_LEG * leg[k - 2] and leg[k] < HALF_LEG * leg[k + 1]]


def _edges(
    record: Record, points: Indices, start: int, stop: int, rested: bool, earlier_away: float | None
) -> tuple[list[tuple[float, float]], bool, float]:
    """Where half cycles of one uninterrupted motion stop and the next ones start, s; whether its start is known; and how far
    from the mean position that is, m, NaN at turning points. ``earlier_away`` says it of a motion that goes on."""
    x, t = record.displacement, record.time
    if len(points) < 2:
        return [], rested, np.nan
    noise = rest_tolerance(x)
    middles = 0.5 * (x[points[1:]] + x[points[:-1]])
    centre = np.array([np.median(middles[max(k - NEARBY, 0) : k + NEARBY + 1]) for k in range(len(middles))])
    amplitude = 0.5 * float(np.median(np.abs(np.diff(x[points[: 2 * NEARBY + 2]]))))
    period = 2.0 * float(np.median(np.diff(t[points[: 2 * NEARBY + 2]])))
    rested = rested or t[start] - t[0] > AT_REST * period
    start = start if rested else 0
    away, from_start = float(x[start] - centre[0]), True
    relative, opposite = abs(away) / amplitude, away * (x[points[0]] - x[start]) < 0.0
    in_the_middle = relative <= (STARTS_IN_THE_MIDDLE if rested else AT_ONCE)
    at_turns = opposite and relative >= (STARTS_IN_THE_MIDDLE if rested else 1.0 - AT_ONCE)
    if earlier_away is not None:
        start, away, from_start, at_turns = 0, earlier_away, False, bool(np.isnan(earlier_away))
        in_the_middle = not at_turns
    if in_the_middle:
        edges, level = [(t[start], t[start])], centre + away
    elif at_turns:
        lasting = HALTED * 0.5 * period
        edges = [(t[start], t[start]), *(_turned(t, x, points, k, lasting) for k in range(len(points)))]
        return _with_end(edges, x, t, points, stop, float(x[points[-2]]), noise), from_start, np.nan
    else:
        edges, level, from_start = _passed(t, x, start, int(points[0]), float(centre[0]), noise), centre, rested
        away = 0.0
    for k, (first, last) in enumerate(pairwise(points.tolist())):
        edges += _passed(t, x, first, last, float(level[k]), noise)
    return _with_end(edges, x, t, points, stop, float(level[-1]), noise), from_start, away


def _with_end(
    edges: list[tuple[float, float]], x: Array, t: Array, points: Indices, stop: int, level: float, noise: float
) -> list[tuple[float, float]]:
    """The edges, and the one at the end of the motion where it reaches ``level`` after its last turning point."""
    last = int(points[-1])
    leg = abs(float(x[points[-1]] - x[points[-2]]))
    passed = _passed(t, x, last, stop, level, noise)
    if passed:
        return [*edges, (passed[0][0], passed[0][0])]
    return [*edges, (t[stop], t[stop])] if abs(x[stop] - level) <= NEAR_MIDDLE * leg else edges


def _passed(t: Array, x: Array, first: int, last: int, level: float, noise: float) -> list[tuple[float, float]]:
    """Where the motion from one sample to another passes ``level``: the time twice, or those of both ends of a pause there."""
    side = x[first : last + 1] - level
    leg = abs(side[-1] - side[0])
    crossed = np.flatnonzero(side[:-1] * side[-1] < 0.0)
    if not crossed.size or side[0] * side[-1] >= 0.0:
        return []
    near = np.flatnonzero(np.abs(side) <= NEAR_MIDDLE * leg)
    if near.size and t[first + near[-1]] - t[first + near[0]] > HALTED * (t[last] - t[first]):
        at = np.flatnonzero(np.abs(side) <= max(AT_MIDDLE * leg, noise))
        halted = at if at.size else near
        return [(float(t[first + halted[0]]), float(t[first + halted[-1]]))]
    k = first + int(crossed[-1])
    a, b = float(x[k] - level), float(x[k + 1] - level)
    at_time = float(t[k] + (t[k + 1] - t[k]) * a / (a - b))
    return [(at_time, at_time)]


def _turned(t: Array, x: Array, points: Indices, k: int, lasting: float) -> tuple[float, float]:
    """The time of a turning point twice, or those of both ends of a pause of more than ``lasting`` s there."""
    point = int(points[k])
    before = _reached(x, int(points[k - 1]) if k else 0, point)
    after = _left(x, point, int(points[k + 1]) if k + 1 < len(points) else len(x) - 1)
    return (t[before], t[after]) if t[after] - t[before] > lasting else (t[point], t[point])


def _reached(x: Array, last: int, meeting: int) -> int:
    """The first sample after ``last`` at which the motion has come to where it rests, or turns, at ``meeting``."""
    away = np.abs(x[last : meeting + 1] - x[meeting])
    moving = np.flatnonzero(away > max(AT_MIDDLE * float(away.max()), 2.0 * rest_tolerance(x)))
    return last + int(moving[-1]) + 1 if moving.size else meeting


def _left(x: Array, meeting: int, following: int) -> int:
    """The last sample before ``following`` at which the motion still is where it rested, or turned, at ``meeting``."""
    away = np.abs(x[meeting : following + 1] - x[meeting])
    moving = np.flatnonzero(away > max(AT_MIDDLE * float(away.max()), 2.0 * rest_tolerance(x)))
    return meeting + int(moving[0]) - 1 if moving.size else meeting


def _number_cycles(
    record: Record, halves: Sequence[tuple[float, float]], from_start: bool, stroke: float, middle: bool, turn: float
) -> Cut:
    """The half cycles numbered and paired, the cycles in levels."""
    half_cycles = tuple(_span(record, k + 1, a, b) for k, (a, b) in enumerate(halves))
    pairs = zip(halves[::2], halves[1::2], strict=False)
    cycles = [_span(record, k + 1, a[0], b[1]) for k, (a, b) in enumerate(pairs)]
    whole = [cycle for cycle in cycles if cycle.last - cycle.first >= FEWEST - 1]
    groups: list[list[CutCycle]] = []
    for cycle in whole:
        if groups and _alike(groups[-1], cycle):
            groups[-1].append(cycle)
        else:
            groups.append([cycle])
    levels, of_cycle = _levels(groups)
    of_half = {2 * number - side: level for number, level in of_cycle.items() for side in (0, 1)}
    return Cut(
        tuple(replace(cycle, level=of_cycle[cycle.number]) for cycle in whole),
        tuple(replace(half, level=of_half.get(half.number, 0)) for half in half_cycles),
        levels, from_start, stroke, middle, turn,
    )  # fmt: skip


def _typical(group: Sequence[CutCycle]) -> tuple[float, float]:
    """The median stroke, m, and the median period, s, of some cycles."""
    stroke = float(np.median([cycle.stroke_m for cycle in group]))
    return stroke, float(np.median([cycle.stop_s - cycle.start_s for cycle in group]))


def _alike(group: Sequence[CutCycle], cycle: CutCycle) -> bool:
    stroke, period = _typical(group)
    same_stroke = abs(cycle.stroke_m / stroke - 1.0) <= SAME_STROKE
    return same_stroke and abs((cycle.stop_s - cycle.start_s) / period - 1.0) <= SAME_PERIOD


def _levels(groups: Sequence[Sequence[CutCycle]]) -> tuple[tuple[Level, ...], dict[int, int]]:
    """The levels, and which one each cycle belongs to; 0 stands for the run-in and the run-out."""
    ramps = _growing(groups)
    ramps |= {len(groups) - 1 - k for k in _growing(groups[::-1])}
    levels: list[Level] = []
    of_cycle: dict[int, int] = {}
    for k, group in enumerate(groups):
        if k not in ramps:
            levels.append(Level(len(levels) + 1, group[0].number, group[-1].number, *_typical(group)))
        of_cycle |= {cycle.number: 0 if k in ramps else len(levels) for cycle in group}
    return tuple(levels), of_cycle


def _growing(groups: Sequence[Sequence[CutCycle]]) -> set[int]:
    """The places of single cycles at the start that grow up to a level."""
    for k, group in enumerate(groups):
        strokes = [_typical(earlier)[0] for earlier in groups[: k + 1]]
        if any(b <= a for a, b in pairwise(strokes)):
            return set()
        if len(group) >= RUN_IN_TO:
            return set(range(k))
        if len(group) > 1:
            return set()
    return set()


def _span(record: Record, number: int, start: float, stop: float) -> CutCycle:
    t, x = record.time, record.displacement
    first = int(np.searchsorted(t, start, side="left"))
    last = max(int(np.searchsorted(t, stop, side="right")) - 1, first)
    ends = np.interp([start, stop], t, x)
    positions = np.r_[ends, x[first : last + 1]]
    return CutCycle(
        number, 0, float(start), float(stop), first, last, float(np.ptp(positions)), float(abs(ends[1] - ends[0]))
    )


def require_cycles(record: Record, purpose: str) -> list[tuple[int, int]]:
    """The whole cycles, or an :class:`InputError` that says what needs them."""
    spans = cycle_bounds(record)
    if not spans:
        raise no_cycle(record, purpose)
    return spans


def no_cycle(record: Record, purpose: str) -> InputError:
    """The error of a record without a whole cycle, for what needs one."""
    return InputError(
        f"{record.name}: no whole cycle in {record.duration:g} s, and {purpose} needs one; "
        "give a record with at least three turning points"
    )


def mean_over_time(values: Array, record: Record, i0: int, i1: int) -> float:
    """The mean of the samples ``[i0, i1)`` of a channel (n,), each weighted by the interval to the next."""
    intervals = np.diff(record.time[i0 : i1 + 1])
    return float(np.sum(values[i0:i1] * intervals) / np.sum(intervals))


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
    if count < MIN_SAMPLES:
        raise InputError(f"samples = {count} is too few for a cycle; give at least {MIN_SAMPLES}")
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
