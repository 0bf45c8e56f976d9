"""Measures of any motion, and whether its whole cycles stand for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.velocity import default_bandwidth, differentiate
from dampyr.records.cycle_analysis.cycles import cut_cycles, similar_cycles, turning_points
from dampyr.records.cycle_analysis.measure import fundamental
from dampyr.records.cycle_analysis.path_work import path_work
from dampyr.records.record import MIN_SAMPLES, Array, Record
from dampyr.shown import Shown

SHARE = 0.5  # of the moving time: cycles that cover less do not stand for the motion
DISTORTION = 0.5  # rms of what the harmonics leave over that of the first: beyond it no cycle is like the next


@dataclass(frozen=True, repr=False)
class Overview(Shown):
    """A motion as a whole, SI.

    Attributes
    ----------
    repeats
        Whether the motion repeats itself: whole cycles cover at least half of the time from the start of the motion
        to the last turning point, a sine with its harmonics misses at most half of it (rms), and its strokes are not
        in rising or falling levels (`dampyr.records.cut_cycles`). Only then do the frequency, the stroke and the energy of
        :func:`measure` stand for the record.
    stroke_m, peak_speed, rms_speed
        Largest less smallest displacement, m; m/s, from the start of the motion on.
    dominant_hz
        Where the spectrum of the velocity is highest, to one over the duration; None for a record that does not move.
    work
        What the force about its mean dissipates over the whole record, J; negative where a damper's force has the wrong sign.
    """

    repeats: bool
    stroke_m: float
    peak_speed: float
    rms_speed: float
    dominant_hz: float | None
    work: float


def overview(record: Record) -> Overview:
    """Describe the motion of a record, whatever it is."""
    speed, dominant = _moving(record)
    return Overview(
        repeats=repeats(record),
        stroke_m=float(np.ptp(record.displacement)),
        peak_speed=float(np.max(np.abs(speed))),
        rms_speed=float(np.sqrt(np.mean(speed**2))),
        dominant_hz=dominant,
        work=work(record),
    )


def dominant_frequency(record: Record) -> float | None:
    """The strongest frequency of the velocity from the motion's begin on, Hz; None of a record that does not move."""
    return _moving(record)[1]


def repeats(record: Record) -> bool:
    """Whether the whole cycles of a record stand for its motion, see :class:`Overview`."""
    spans, points = similar_cycles(record), turning_points(record)
    if not spans or cut_cycles(record).graded:
        return False
    moving = float(record.time[points[-1]]) - motion_start(record)
    covered = float(record.time[spans[-1][1]] - record.time[spans[0][0]])
    return covered >= SHARE * moving and fundamental(record)[1] <= DISTORTION


def work(record: Record) -> float:
    """What the force about its mean dissipates over the whole record, J."""
    force = record.force - np.mean(record.force)  # else gas force times the net way would count as dissipated
    return path_work(record.displacement, force)


def _moving(record: Record) -> tuple[Array, float | None]:
    """The velocity where the record is in motion, everywhere where it never is, and its strongest frequency."""
    first = int(np.searchsorted(record.time, motion_start(record)))
    moves = record.n - first >= MIN_SAMPLES
    part = slice(first if moves else 0, record.n)
    speed = differentiate(record.time, record.displacement, default_bandwidth(record))[part]
    return speed, _dominant(record.time[part], speed, record.dt) if moves else None


def _dominant(time: Array, speed: Array, dt: float) -> float:
    even = np.arange(time[0], time[-1], dt)
    values = np.interp(even, time, speed)
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values))))
    return float(np.fft.rfftfreq(len(values), dt)[int(np.argmax(spectrum))])
