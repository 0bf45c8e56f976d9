r"""Whether a channel went through a moving average: recognised by the zeros of its spectrum.

An average over N samples, T = N dt, has the gain :math:`|\sin \pi f T| / (N |\sin \pi f dt|)`: whatever was in the channel, its
noise too, is gone at 1/T and its multiples. With the power P of the channel's second differences (a Hann window over all of it)
the *contrast* of a window is the median of :math:`10 \log_{10} P` in the middles between these frequencies less that near
them, in dB: about 15 behind a moving average, 0 without. The logarithm of noise's P scatters by 5.6 dB whatever the noise,
which gives the standard error.

The lines of a periodic motion have zeros of their own (a square wave has no even harmonics). So of a motion that repeats itself
the difference of the channel and itself one period later is taken, which leaves the noise, and of its spectrum only what this
difference does not weaken. Where nothing is left, as of a computed signal that repeats itself exactly, nothing is recognised.
A building in an earthquake nearly repeats itself: of such a motion windows are tried to a quarter of its strongest period too.

Where the converter's step q is known, there is a second sign: N times the differences of successive samples of an average over
N are multiples of q, and less than N times are not. (The smoothed values alone only tell q/N.)
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from dampyr.records.checks.overview import dominant_frequency, repeats
from dampyr.records.conditioning.moving_average import AVERAGED, UNITS
from dampyr.records.cycle_analysis.cycles import RUN_IN_TO, cut_cycles
from dampyr.records.cycle_analysis.measure import fundamental
from dampyr.records.record import Array, Record
from dampyr.records.record_thresholds import RecordThresholds

Bools = NDArray[np.bool_]
SHORTEST = 4  # samples: shorter windows have no whole lobe between two zeros below half the sampling rate
LOBES = (3, 12)  # how many zeros are looked at: rounding hides all but the first ones, or does not
NEAR, MIDDLE = 0.12, 0.2  # how far from a zero and from the middle of a lobe, in lobes
EASED = 0.5  # of what is needed, for a window that another channel of the record shows clearly
IN_LOBES = 0.7  # of the zeros must each lie below their sides by half of that: every second one is not enough
SCATTER = 5.57  # dB, the standard deviation of the logarithm of a periodogram of noise
OF_MEDIANS = 1.5  # the variance of a median over that of a mean, of logarithms of noise
LEAKED = 1.5  # lines that share their noise under a Hann window
SEEN = 0.5  # of the largest gain of the difference of two periods
OF_PERIOD = 0.25  # the widest window that is tried: longer ones take a third of the motion itself
COARSE = 0.01  # of a window: at the twelfth zero a window that much longer is still within `NEAR` of it
WINDOWS = 16  # that a record must hold at least
FEW = 0.1  # of the samples: where fewer differ from one period to the next, these are single steps and no noise
ROUNDING = 1e-12  # of the channel's largest value: differences below are rounding
AS_GOOD = 0.8  # of the best contrast: a third of a window has a third of its zeros, so the widest such is taken
ON_STEP = 0.02  # of a converter's step


@dataclass(frozen=True)
class Recognised:
    """A moving average that a channel shows: ``samples`` of its window, the same in s and in periods (or None).

    How clearly: ``contrast`` in dB, and in standard errors of what noise would give (``sigmas``); ``on_grid``: the
    converter's step of which N times the sample differences are multiples, where it is known.
    """

    channel: str
    samples: int
    window: float
    periods: float | None
    contrast: float
    sigmas: float
    on_grid: float | None = None


def recognise_smoothing(record: Record, steps: Mapping[str, float] | None = None) -> tuple[Recognised, ...]:
    """The moving averages that a record's displacement, velocity and force show, at most one a channel.

    ``steps``: the converter's step of a channel in its SI unit, where it is known, such as ``{"displacement":
    5e-6}``. Windows from four samples to a quarter of the motion's period, or of its strongest one, and to a sixteenth
    of the record, are tried; of a test with rising or falling strokes within one level of three cycles or more.
    Channels that the record says are smoothed are left out, and so is a record with uneven sampling.
    """
    if not record.evenly_sampled:
        return ()
    part, period = _telling_part(record)
    if part is None:
        return ()
    dominant = None if period is not None else dominant_frequency(record)
    longest = period if not dominant else 1.0 / dominant / record.dt
    stated = record.smoothed.channels if record.smoothed is not None else ()
    channels = {c: getattr(record, c)[part] for c in AVERAGED if c not in stated and getattr(record, c) is not None}
    windows = {c: _by_zeros(values, period, longest, record.thresholds) for c, values in channels.items()}
    clear = [window[0] for window in windows.values() if window is not None]
    recognised = []
    for channel, values in channels.items():
        window = windows[channel]
        if window is None and clear:  # what is clear in another channel needs less to be believed in this one
            near = range(min(clear) - 1, max(clear) + 2)
            window = _by_zeros(values, period, longest, record.thresholds, near, EASED)
        step = (steps or {}).get(channel)
        on_grid = None if step is None else _by_grid(values, step, longest)
        if window is None and on_grid is None:
            continue
        samples, contrast, sigmas = window or (0, math.nan, math.nan)
        samples = on_grid or samples
        periods = None if period is None else samples / period
        shown = step if on_grid is not None else None
        recognised.append(Recognised(channel, samples, samples * record.dt, periods, contrast, sigmas, shown))
    return tuple(recognised)


def common_windows(recognised: Mapping[str, Recognised]) -> dict[str, list[str]]:
    """The windows to declare, each with the names of the records that it undoes, those of the most records first.

    A declared window is rounded to samples in each record, and one of s or of periods is tried a sample longer and shorter
    (`dampyr.records.conditioning.smoothing.with_smoothing`). Of the windows that undo as many records s are preferred to
    samples, and these to periods: a motion's measured period is known to a hundredth at best, which is more than a sample of a
    wide window.
    """
    remaining, windows = dict(recognised), dict[str, list[str]]()
    while remaining:
        undone: dict[tuple[str, float], list[str]] = {}
        for unit in UNITS:
            for value in chain.from_iterable(_rounded(average, unit) for average in remaining.values()):
                undone[unit, value] = [name for name, average in remaining.items() if _undoes(average, unit, value)]
        best, names = max(undone.items(), key=lambda item: len(item[1]))  # the first of equals
        windows[f"{best[1]:g} {best[0]}"] = names
        remaining = {name: average for name, average in remaining.items() if name not in names}
    return dict(sorted(windows.items(), key=lambda item: -len(item[1])))


def _size(average: Recognised, unit: str) -> float | None:
    """The window in one of `UNITS`."""
    return {"s": average.window, "samples": float(average.samples), "periods": average.periods}[unit]


def _rounded(average: Recognised, unit: str) -> list[float]:
    """The window as it could be declared in a unit, from one digit to four."""
    size = _size(average, unit)
    return [] if size is None else [float(f"{size:.{digits}g}") for digits in range(1, 5)]


def _undoes(average: Recognised, unit: str, value: float) -> bool:
    """Whether a declared window is that of a record, with the sample more or less that is tried where it is not in samples."""
    size = _size(average, unit)
    if size is None:
        return False
    return abs(round(value * average.samples / size) - average.samples) <= (0 if unit == "samples" else 1)


def _telling_part(record: Record) -> tuple[slice | None, float | None]:
    """The samples in whose spectrum zeros tell something, and the period in samples of a motion that repeats itself there.

    Of a test of levels that is the level with most samples, of three cycles or more. Strokes that rise from cycle to
    cycle, as in quasi-static tests, have lines, corners and straight pieces between digitised points that look like
    an average: none then.
    """
    cut = cut_cycles(record)
    if not cut.graded:
        return slice(0, record.n), 1.0 / fundamental(record)[0] / record.dt if repeats(record) else None
    spans = [(cut.cycles[level.first - 1].first, cut.cycles[level.last - 1].last + 1, level) for level in cut.levels]
    first, last, level = max(spans, key=lambda span: (span[2].count >= RUN_IN_TO, span[1] - span[0]))
    return (slice(first, last), level.period_s / record.dt) if level.count >= RUN_IN_TO else (None, None)


def _last_window(n: int, longest: float | None) -> int:
    return int(min(n / WINDOWS, n if longest is None else OF_PERIOD * longest))


def _by_zeros(
    values: Array,
    period: float | None,
    longest: float | None,
    limits: RecordThresholds,
    tried: range | None = None,
    part: float = 1.0,
) -> tuple[int, float, float] | None:
    """The window, its contrast in dB and that in standard errors; None where none stands out.

    ``longest``: the period in samples that bounds the windows. ``tried``: these windows only, which need ``part`` of the
    contrast and of the standard errors.
    """
    lag = None if period is None else round(period)
    rest = values if lag is None else values[lag:] - values[:-lag]
    bent = np.diff(rest, 2)
    if bent.size < WINDOWS * SHORTEST or np.mean(np.abs(bent) > ROUNDING * np.max(np.abs(values))) < FEW:
        return None
    power = np.abs(np.fft.rfft(bent * np.hanning(bent.size))) ** 2
    frequency = np.arange(power.size) / bent.size  # cycles per sample
    seen = power > 0.0
    if lag is not None:
        seen &= np.abs(np.sin(np.pi * frequency * lag)) > SEEN
    level, at = 10.0 * np.log10(power[seen]), frequency[seen]
    passed = _passed(level, at, tried or _spaced(_last_window(bent.size, longest)), limits, part)
    if tried is None:
        close = {k + away for k in passed for away in range(-round(COARSE * k) - 1, round(COARSE * k) + 2)}
        passed |= _passed(level, at, sorted(k for k in close if k >= SHORTEST and k not in passed), limits, part)
    if not passed:
        return None
    best = max(contrast for contrast, _ in passed.values())
    widest = max(k for k, (contrast, _) in passed.items() if contrast >= AS_GOOD * best)
    near = [k for k in passed if abs(k - widest) <= max(1, round(0.1 * widest))]
    samples = max(near, key=lambda k: passed[k][0] * math.sqrt(min(passed[k][1], 1e3)))
    return samples, *passed[samples]


def _spaced(last: int) -> list[int]:
    """Windows to try first: all, or of wide ones every hundredth part; what stands out there is looked at closely."""
    windows = [SHORTEST]
    while windows[-1] < last:
        windows.append(windows[-1] + max(1, int(COARSE * windows[-1])))
    return [k for k in windows if k <= last]


def _passed(
    level: Array, at: Array, windows: Iterable[int], limits: RecordThresholds, part: float
) -> dict[int, tuple[float, float]]:
    """The windows that stand out, each with its contrast in dB and in standard errors."""
    passed = {}
    for samples in windows:
        half_depth = 0.5 * limits.smoothing_contrast
        contrasts = [
            _contrast(level, at, samples, lobes, part * limits.smoothing_contrast, half_depth) for lobes in LOBES
        ]
        sure = [(contrast, sigmas) for contrast, sigmas in contrasts if sigmas >= part * limits.smoothing_sigmas]
        if sure:
            passed[samples] = max(sure)
    return passed


def _contrast(
    level: Array, frequency: Array, samples: int, lobes: int, least: float, depth: float
) -> tuple[float, float]:
    """Of a window the contrast in dB, and how many standard errors of noise it is; nothing below ``least`` dB, or where most
    zeros are less than ``depth`` dB deep."""
    zeros = min(lobes, int(samples / 2 - 0.7))  # with the middle of the lobe beyond
    stop = int(np.searchsorted(frequency, (zeros + 0.5 + MIDDLE) / samples))
    phase, level = frequency[:stop] * samples, level[:stop]
    lobe = np.rint(phase)
    at_zero = (np.abs(phase - lobe) < NEAR) & (lobe >= 1)
    between = (np.abs(phase - lobe) > 0.5 - MIDDLE) & (phase > 0.5 - MIDDLE)
    few, many = int(np.sum(at_zero)), int(np.sum(between))
    if few < 4 or many < 4:
        return -math.inf, 0.0
    contrast = float(np.median(level[between]) - np.median(level[at_zero]))
    if contrast < least or not _in_each_lobe(phase, level, at_zero, between, zeros, depth):
        return -math.inf, 0.0
    return contrast, contrast / (SCATTER * math.sqrt(OF_MEDIANS * LEAKED * (1.0 / few + 1.0 / many)))


def _in_each_lobe(phase: Array, level: Array, at_zero: Bools, between: Bools, zeros: int, depth: float) -> bool:
    """Whether most zeros lie ``depth`` dB below the lobes on both sides: not one slope, and not every second zero."""
    deep = 0
    for k in range(1, zeros + 1):
        at_this_zero = level[at_zero & (np.abs(phase - k) < 0.5)]
        sides = [level[between & (np.abs(phase - middle) < 0.5)] for middle in (k - 0.5, k + 0.5)]
        if at_this_zero.size and all(side.size for side in sides):
            deep += min(float(np.median(side)) for side in sides) - float(np.median(at_this_zero)) > depth
    return deep >= IN_LOBES * zeros


def _by_grid(values: Array, step: float, longest: float | None) -> int | None:
    """The smallest N of which N times the differences are multiples of ``step``; None where they are without, or never are."""
    differences = np.diff(values) / step
    for samples in range(1, _last_window(values.size, longest) + 1):
        whole = samples * differences[samples:-samples]  # at its ends an average may be over fewer samples
        if whole.size and np.all(np.abs(whole - np.rint(whole)) < ON_STEP):
            return samples if samples >= SHORTEST else None
    return None
