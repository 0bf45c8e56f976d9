"""Break-away: the force that it takes to leave a rest, against the kinetic force of the slow stroke after it.

Rests and strokes are told by the speed. The break-away force is the largest in the first half of a stroke's way, the
kinetic force the median from 50 % to 90 % of it; both count positive against the motion, so that a gas force adds to one
direction and is taken from the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dampyr.errors import InputError
from dampyr.records.record import Array, Record

SMOOTHED = 0.1  # s of the speed by which rest and motion are told apart
AT_REST = 0.2  # of the fastest speed
FASTEST = 0.95  # quantile of the speeds: noise makes none
LEAST_REST = 0.3  # s
LEAST_WAY = 0.1  # of the whole stroke: a shorter motion is none
SLIDING = (0.5, 0.9)  # of a stroke's way
NOISES = 5.0  # times the noise: what a peak stands above the kinetic force


@dataclass(frozen=True)
class BreakAwayForce:
    """Of one rest (``dwell``, s) and the stroke after it; forces in N, the ``speed`` in m/s.

    ``reason`` says why there is no peak: then the break-away force is what the stroke takes anyway.
    """

    extension: bool
    dwell: float
    speed: float
    force: float
    kinetic: float
    noise: float
    reason: str = ""

    @property
    def ratio(self) -> float:
        """Break-away over kinetic force."""
        return self.force / self.kinetic


def break_away_forces(record: Record) -> list[BreakAwayForce]:
    """The break-away force after every rest of at least 0.3 s; InputError where no stroke follows one."""
    found = [_force(record, *rest, stop) for rest, stop in _rests_and_strokes(record)]
    if not found:
        raise InputError(
            f"{record.name}: no stroke follows a rest of {LEAST_REST:g} s; record strokes with a pause before each"
        )
    return found


def rests(record: Record) -> list[tuple[int, int]]:
    """First and last sample (exclusive) of every rest of at least 0.3 s."""
    half = max(1, round(0.5 * SMOOTHED / record.dt))
    k = np.arange(record.n)
    early, late = np.maximum(k - half, 0), np.minimum(k + half, record.n - 1)
    x, t = record.displacement, record.time
    speed = np.abs((x[late] - x[early]) / (t[late] - t[early]))
    still = np.r_[False, speed < AT_REST * np.quantile(speed, FASTEST), False]
    edges = np.flatnonzero(still[1:] != still[:-1])
    pairs = [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]
    return [(first, last) for first, last in pairs if t[last - 1] - t[first] >= LEAST_REST]


def _rests_and_strokes(record: Record) -> list[tuple[tuple[int, int], int]]:
    """Each rest, and where the stroke after it has come to the next rest, or the record to its end."""
    found, stroke = rests(record), float(np.ptp(record.displacement))
    stops = [*(first for first, _ in found[1:]), record.n][: len(found)]
    return [
        (rest, stop)
        for rest, stop in zip(found, stops, strict=True)
        if stop > rest[1] and abs(record.displacement[stop - 1] - record.displacement[rest[1] - 1]) > LEAST_WAY * stroke
    ]


def _force(record: Record, first: int, last: int, stop: int) -> BreakAwayForce:
    x, t = record.displacement, record.time
    begin = max(first, last - max(1, round(SMOOTHED / record.dt)))  # the smoothed speed sees the motion early
    way = x[begin:stop] - x[begin]
    sign = 1.0 if way[-1] > 0.0 else -1.0
    share: Array = way / way[-1]
    force = sign * record.force[begin:stop]
    half, end = (int(np.argmax(share >= level)) for level in SLIDING)
    sliding = force[half:end]
    kinetic = float(np.median(sliding))
    noise = float(1.4826 * np.median(np.abs(sliding - kinetic)))
    largest = float(force[:half].max())
    speed = float(abs(way[end] - way[half]) / (t[begin + end] - t[begin + half]))
    peak = largest - kinetic > NOISES * noise
    return BreakAwayForce(
        sign > 0.0,
        float(t[last - 1] - t[first]),
        speed,
        largest,
        kinetic,
        noise,
        "" if peak else "no peak above the kinetic force and its noise",
    )
