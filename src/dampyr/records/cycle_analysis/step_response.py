r"""Response time: how fast the force follows a step of the input while the damper moves at a constant speed.

.. math:: y(t) = \frac{F(t) - F_0}{F_{100} - F_0}

The time counts from where the input has done 10 % of its step. :math:`F_0` is the median of the force before it,
:math:`F_{100}` that of the last part of the stroke's constant-speed part; the dead time ends at :math:`y` = 1 %, and
t63 and t90 are where it passes 63.2 % and 90 %, between samples by linear interpolation. The force has settled where it stays
within 2 %, or three times its noise, of its end for 10 ms. The delay of the load cell's own filter is in all of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf
from typing import Literal

import numpy as np

from dampyr.errors import InputError
from dampyr.records.record import Array, Record

ONSET = 0.1  # of the input's step: there the time is 0
DEAD, T63, T90 = 0.01, 1.0 - np.exp(-1.0), 0.9  # of the force's step
LAST = 0.1  # of the time after the step: its median is the end of the force
SETTLED, STAYS = 0.02, 0.010  # of the force's step; s
SMALLEST = 0.02  # of the largest force: a smaller step has no response time
NOISES = 5.0  # times the noise, likewise
SETTLED_NOISES = 3.0  # times the noise: what settles no closer
STEADY = 0.1  # of the speed: more than it may differ by in the window
AT_SPEED = 0.95  # of the stroke's median speed: the constant-speed part begins and ends there
SMOOTHED = 0.01  # s of the speed that is compared: the encoder's counts are coarse
SAME_LEVEL = 0.02  # of the range of the input: less is no step
MIN_PART = 5  # samples before a step, and after it


@dataclass(frozen=True)
class StepResponse:
    """Of one step of the input; forces in N, times in s from the ``onset``. A time that is None has its ``reason``.

    ``rise`` says whether the input rises, ``extension`` the direction of the motion, ``speed`` (m/s) the median in the window.
    """

    rise: bool
    extension: bool
    speed: float
    low: float
    high: float
    onset: float
    force_before: float
    force_after: float
    noise: float
    dead_time: float | None = None
    t63: float | None = None
    t90: float | None = None
    settled: float | None = None
    reason: str = ""

    @property
    def step(self) -> Literal["rise", "fall"]:
        """The direction of the input's step."""
        return "rise" if self.rise else "fall"


def response_times(record: Record) -> list[StepResponse]:
    """The response to each step of the input; InputError where the input has none.

    The input is the record's: the voltage as read back where the rig reads it, else as commanded; or the current.
    """
    values = record.input_channel
    steps = [] if values is None or isinstance(values, float) else _steps(np.asarray(values))
    if not steps:
        raise InputError(f"{record.name}: its input has no step; record one that jumps between two levels")
    ends = [*(place for place, _, _ in steps[1:]), record.n]
    starts = [0, *(place for place, _, _ in steps[:-1])]
    return [
        _response(record, np.asarray(values), step, start, end)
        for step, start, end in zip(steps, starts, ends, strict=True)
    ]


def _steps(values: Array) -> list[tuple[int, float, float]]:
    """First sample beyond the middle of each step, and the levels before and after it."""
    low, high = (float(np.median(values[side])) for side in _sides(values))
    if not high - low > SAME_LEVEL * max(abs(low), abs(high)) or low == high:
        return []
    above = values > 0.5 * (low + high)
    places = np.flatnonzero(above[1:] != above[:-1]) + 1
    return [(int(k), *((low, high) if above[k] else (high, low))) for k in places]


def _sides(values: Array) -> tuple[Array, Array]:
    middle = 0.5 * (values.min() + values.max())
    return values <= middle, values >= middle


def _response(record: Record, values: Array, step: tuple[int, float, float], start: int, end: int) -> StepResponse:
    place, before, after = step
    onset = _onset(record.time, values, place, before, after)
    speed, first, last = _at_speed(record, place, start, end)
    force = record.force
    early = force[(first + place) // 2 : place - 1]
    length = last - place
    late = force[max(place, last - max(MIN_PART, round(LAST * length))) : last]
    known = min(early.size, late.size) >= MIN_PART and length >= 2 * MIN_PART
    f0, f100 = (float(np.median(part)) if part.size else float("nan") for part in (early, late))
    noise = float(1.4826 * np.median(np.abs(early - f0))) if early.size else float("nan")
    reason = "the step lies outside of the constant-speed part of a stroke; make the stroke longer"
    if known:
        reason = _why_not(_variation(record, first, last), f0, f100, noise)
    untimed = StepResponse(
        rise=after > before, extension=speed > 0.0, speed=abs(speed), low=min(before, after), high=max(before, after),
        onset=onset, force_before=f0, force_after=f100, noise=noise, reason=reason,
    )  # fmt: skip
    if reason:
        return untimed
    time, y = record.time[place - 1 : last] - onset, (force[place - 1 : last] - f0) / (f100 - f0)
    noise_share = noise / abs(f100 - f0)
    dead = _reached(time, y, DEAD) if SETTLED_NOISES * noise_share <= DEAD else None
    return replace(
        untimed,
        dead_time=dead,
        t63=_reached(time, y, T63),
        t90=_reached(time, y, T90),
        settled=_settled(time, y, max(SETTLED, SETTLED_NOISES * noise_share)),
        reason="" if dead is not None else f"no dead time: noise of {noise:.3g} N hides 1 % of the step",
    )


def _onset(time: Array, values: Array, place: int, before: float, after: float) -> float:
    """When the input has done 10 % of its step."""
    level = before + ONSET * (after - before)
    beyond = (values - level) * np.sign(after - before) > 0.0
    k = place
    while k > 1 and beyond[k - 1]:
        k -= 1
    part = (level - values[k - 1]) / (values[k] - values[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))


def _smooth_speed(record: Record) -> Array:
    """The speed over `SMOOTHED` s."""
    half = max(1, round(0.5 * SMOOTHED / record.dt))
    k = np.arange(record.n)
    early, late = np.maximum(k - half, 0), np.minimum(k + half, record.n - 1)
    speed: Array = (record.displacement[late] - record.displacement[early]) / (record.time[late] - record.time[early])
    return speed


def _at_speed(record: Record, place: int, start: int, end: int) -> tuple[float, int, int]:
    """The signed speed of the stroke about a step, and the first and the last sample (exclusive) of its constant-speed part,
    from the step before to the next."""
    speed = _smooth_speed(record)
    way = 1.0 if speed[place] > 0.0 else -1.0
    moving = way * speed > 0.5 * abs(speed[place])
    first, last = place, place
    while first > start and moving[first - 1]:
        first -= 1
    while last < end and moving[last]:
        last += 1
    if last - first < 2:
        return way * abs(float(speed[place])), place, place
    typical = float(np.median(way * speed[first:last]))
    at_speed = first + np.flatnonzero(way * speed[first:last] >= AT_SPEED * typical)
    half = max(1, round(0.5 * SMOOTHED / record.dt))  # so far the smoothed speed sees the turn
    return way * typical, min(place, int(at_speed[0]) + half), max(place, int(at_speed[-1]) + 1 - half)


def _variation(record: Record, first: int, last: int) -> float:
    """How far the speed strays from its median in the window, relative to it."""
    speed = np.abs(_smooth_speed(record)[first:last])
    typical = float(np.median(speed))
    return float(np.max(np.abs(speed - typical)) / typical) if typical else inf


def _why_not(variation: float, f0: float, f100: float, noise: float) -> str:
    """Why a step has no times; empty where it has."""
    if variation >= STEADY:
        return f"the speed varies by {100 * variation:.2g} % in the window, {100 * STEADY:g} % or more; learn the drive"
    least = max(NOISES * noise, SMALLEST * max(abs(f0), abs(f100)))
    if abs(f100 - f0) < least:
        return f"the force changes by {abs(f100 - f0):.3g} N, less than {least:.3g} N (5 sigma or 2 %)"
    return ""


def _reached(time: Array, y: Array, level: float) -> float | None:
    """When ``y`` first passes ``level``, by linear interpolation; None where it does not."""
    beyond = np.flatnonzero(y >= level)
    if not beyond.size:
        return None
    k = int(beyond[0])
    if k == 0:
        return float(time[0])
    return float(time[k - 1] + (level - y[k - 1]) / (y[k] - y[k - 1]) * (time[k] - time[k - 1]))


def _settled(time: Array, y: Array, band: float) -> float | None:
    """From when on the force stays within ``band`` of its end for `STAYS` s; None where it does not."""
    outside = np.flatnonzero(np.abs(y - 1.0) > band)
    edges = [-1, *outside.tolist(), y.size]
    for before, after in pairwise(edges):
        if after - before > 1 and time[after - 1] - time[before + 1] >= STAYS:
            return float(time[before + 1])
    return None
