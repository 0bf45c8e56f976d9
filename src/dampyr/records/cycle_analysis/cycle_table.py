"""Every whole cycle of a record by itself: what a damper dynamometer prints.

The peak-velocity pick-up is the mean of the force over a window of phase, that in which the velocity is above 95 % of
its peak (on a sine 18 degrees to each side of it, and 98.3 % of the peak velocity on average). One sample at the peak
would carry all of the noise. Its standard error is :math:`s/\\sqrt{n}` with n samples in the window and the deviation
s of the samples of all windows of a level about their own mean and one common parabola over the position.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from dampyr.models.numerics.differentiation import carried
from dampyr.records.conditioning.velocity import PER_TEST_FREQUENCY, WITHOUT_CYCLES, differentiate
from dampyr.records.cycle_analysis.cycles import Cut, CutCycle, cut_cycles, no_cycle
from dampyr.records.record import Array, Record

WINDOW = 0.95  # of the peak velocity
FEW = 20  # samples of a level: a local cubic needs more
FREEDOM = 4  # degrees of freedom that a standard error needs

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Cycle:
    """One whole cycle, SI.

    ``number`` counts from 1 from the start of the motion, ``level`` is the number of its level, 0 of the run-in and
    the run-out (`dampyr.records.cut_cycles`). ``start_s`` and ``period_s``; ``stroke_m`` from its lowest to its
    highest point, ``open_m`` from its start to its end; ``least_force`` and ``largest_force``; ``energy`` dissipated,
    J. The peak-velocity pick-up: ``speed_out`` and ``speed_in`` are the largest velocities of extension (positive)
    and compression (negative), m/s, ``force_out`` and ``force_in`` the mean forces above 95 % of them less the offset
    of the record, N. ``error_out``, ``error_in`` and ``energy_error`` are standard errors by the noise within the
    record, None where it has too few samples to tell.
    """

    number: int
    level: int
    start_s: float
    period_s: float
    stroke_m: float
    open_m: float
    least_force: float
    largest_force: float
    energy: float
    speed_out: float
    force_out: float
    speed_in: float
    force_in: float
    error_out: float | None
    error_in: float | None
    energy_error: float | None


def cycle_table(record: Record, offset: float | None = None, cut: Cut | None = None) -> list[Cycle]:
    """The whole cycles in their order, as `dampyr.records.cut_cycles` cuts them, or as ``cut`` has them.

    The velocity is derived level by level, since it leaps where a step of amplitude begins, at 15 times the level's
    frequency. ``offset`` in N is taken from the forces at peak velocity; None takes the mean force over the cycles of
    all levels. What comes before the first turning point of a motion that begins in the middle is left out of the
    pick-up: there a damper comes from rest.

    Raises InputError where there is no whole cycle.
    """
    cut = cut_cycles(record) if cut is None else cut
    if not cut.cycles:
        raise no_cycle(record, "a table of cycles")
    mean = _mean_force(record, [cycle for cycle in cut.cycles if cycle.level] or cut.cycles)
    zero = mean if offset is None else offset
    table: list[Cycle] = []
    for _, group in groupby(cut.cycles, key=lambda cycle: cycle.level or -cycle.number):
        level = list(group)
        speed = _speed(record, level)
        windows = {way: [_window(record, cut, cycle, way * speed) for cycle in level] for way in (1, -1)}
        noise = {way: _noise(record, windows[way], level) for way in (1, -1)}
        for k, cycle in enumerate(level):
            force, x = record.force[cycle.first : cycle.last + 1], record.displacement[cycle.first : cycle.last + 1]
            out, back = windows[1][k], windows[-1][k]
            # the deviation of a loop integral by trapezoids over that of independent samples of the force, m
            reach = float(np.linalg.norm(np.gradient(x)))
            both = [deviation for deviation in noise.values() if deviation is not None]
            energy_error = math.hypot(*both) / math.sqrt(len(both)) * reach if both else None
            table.append(
                Cycle(
                    number=cycle.number,
                    level=cycle.level,
                    start_s=cycle.start_s,
                    period_s=cycle.stop_s - cycle.start_s,
                    stroke_m=cycle.stroke_m,
                    open_m=cycle.open_m,
                    least_force=float(force.min()),
                    largest_force=float(force.max()),
                    energy=_energy(record, cycle, mean),
                    speed_out=float(np.max(speed[out])),
                    force_out=float(np.mean(record.force[out]) - zero),
                    speed_in=float(np.min(speed[back])),
                    force_in=float(np.mean(record.force[back]) - zero),
                    error_out=_error(noise[1], out),
                    error_in=_error(noise[-1], back),
                    energy_error=energy_error,
                )
            )
    return table


def _mean_force(record: Record, spans: Sequence[CutCycle]) -> float:
    """The mean over these cycles, each instant weighted by its sampling interval."""
    edges = np.gradient(record.time)
    weights = np.zeros(record.n)
    for cycle in spans:
        weights[cycle.first : cycle.last + 1] = edges[cycle.first : cycle.last + 1]
    return float(np.average(record.force, weights=weights))


def _speed(record: Record, level: Sequence[CutCycle]) -> Array:
    """The velocity ``(n,)``, m/s, of the cycles of one level, NaN elsewhere; cycles that a pause parts by themselves."""
    out = np.full(record.n, np.nan)
    period = float(np.median([cycle.stop_s - cycle.start_s for cycle in level]))
    bandwidth = min(PER_TEST_FREQUENCY / period, WITHOUT_CYCLES / record.dt)
    begin = 0
    for k, cycle in enumerate(level):
        if k + 1 < len(level) and level[k + 1].first - cycle.last <= 2:
            continue
        part = slice(level[begin].first, cycle.last + 1)
        low, high = carried(record.dt, float(record.time[part][-1] - record.time[part][0]))
        carried_bandwidth = None if part.stop - part.start < FEW else min(max(bandwidth, low), high)
        out[part] = differentiate(record.time[part], record.displacement[part], carried_bandwidth)
        begin = k + 1
    return out


def _window(record: Record, cut: Cut, cycle: CutCycle, speed: Array) -> Indices:
    """The samples of a cycle at which ``speed`` is above 95 % of its peak."""
    first = cycle.first
    if cycle.number == 1 and cut.begins_in_the_middle and cut.from_start:
        first = int(np.clip(np.searchsorted(record.time, cut.first_turn), cycle.first, cycle.last))
    if not np.any(
        speed[first : cycle.last + 1] > 0.0
    ):  # an irregular motion may not move this way after its first turn
        first = cycle.first
    part = speed[first : cycle.last + 1]
    peak = float(np.max(part))
    return first + np.flatnonzero(part >= (WINDOW * peak if peak > 0.0 else peak))


def _noise(record: Record, windows: Sequence[Indices], level: Sequence[CutCycle]) -> float | None:
    """The deviation of the samples in the windows of one direction, N; None where they are too few."""
    force, columns, count = [], [], 0
    for window, cycle in zip(windows, level, strict=True):
        for run in np.split(window, np.flatnonzero(np.diff(window) > 1) + 1):
            if run.size < 2:
                continue
            u = (record.displacement[run] - np.mean(record.displacement[run])) / cycle.stroke_m
            force.append(record.force[run] - np.mean(record.force[run]))
            columns.append(np.column_stack([u, u**2 - np.mean(u**2)]))
            count += 1
    if not count:
        return None
    f, basis = np.concatenate(force), np.concatenate(columns)
    freedom = f.size - count - 2
    if freedom < FREEDOM:
        return None
    left = f - basis @ np.linalg.lstsq(basis, f, rcond=None)[0]
    return float(np.sqrt(left @ left / freedom))


def _error(noise: float | None, window: Indices) -> float | None:
    return None if noise is None else noise / math.sqrt(window.size)


def _energy(record: Record, cycle: CutCycle, mean: float) -> float:
    """The loop integral from the start to the end of a cycle, by trapezoids; both lie between samples.

    The mean force is left out, so that gas force times drift is not counted.
    """
    ends = np.array([cycle.start_s, cycle.stop_s])
    inner = slice(cycle.first, cycle.last + 1)
    x, f = (np.interp(ends, record.time, values) for values in (record.displacement, record.force - mean))
    path = np.r_[x[0], record.displacement[inner], x[1]]
    force = np.r_[f[0], record.force[inner] - mean, f[1]]
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(path)))
