"""Records that went through a moving average, declared when they are read: undone, or put on the model's force instead.

A smoothed hysteretic force is not what the same damper gives along a smoothed motion, so a record whose force and displacement
were smoothed cannot be compared with a model as it is. Where the average can be undone
(`dampyr.records.conditioning.smoothing_inverse`) the record holds raw channels again. Where the force cannot, the record says
so (``record.smoothed``), and fits, scores and predictions put the model's force through the same average before they compare:
over whole windows only.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from dampyr.errors import InputError
from dampyr.records.checks.overview import repeats
from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.integrated_displacement import integral, is_integrated
from dampyr.records.conditioning.moving_average import Alignment, Declaration, MovingAverage, reach_of, whole_windows
from dampyr.records.conditioning.smoothing_inverse import undo
from dampyr.records.cycle_analysis.cycles import cycle_bounds
from dampyr.records.cycle_analysis.measure import fundamental
from dampyr.records.record import CHANNELS, Array, Record

PROVENANCE = "smoothing"
CLEARER = 0.5  # times the noise: of windows one sample apart the right one leaves far less than its neighbours
ALIKE = 1.2  # times the noise: in a channel without noise all windows leave the same


def with_smoothing(record: Record, declared: Any) -> Record:
    """The record with a declared moving average undone where it can be, else noted in ``record.smoothed``.

    ``declared`` is what :meth:`dampyr.records.Declaration.of` takes, such as ``0.3`` (s) or ``"0.1 periods, trailing"``. The
    window in samples follows from the sampling interval, of periods from the measured frequency; where a window one sample
    longer or shorter leaves less than half of the noise in a channel and no more in the others, that one is taken. The history
    says which, how often an error of the smoothed values is multiplied, and of a channel that stays smoothed why.

    A displacement that is the integral of a smoothed velocity is integrated again from the raw one, or stays smoothed with it.

    Raises
    ------
    InputError
        The sampling is uneven, the window has fewer than two samples or more than the record, a window in periods is declared
        of a motion without whole cycles, or the record is declared smoothed already.
    """
    declaration = Declaration.of(declared)
    if record.smoothed is not None or PROVENANCE in record.provenance:
        raise InputError(f"{record.name} is declared smoothed already; declare it once")
    if not record.evenly_sampled:
        raise InputError(
            f"{record.name}: its sampling steps differ by more than 1 %, so that no moving average of samples is undone or "
            "repeated; resample it evenly, or leave smoothed out"
        )
    integrated = is_integrated(record)
    channels = tuple(
        c for c in declaration.channels if getattr(record, c) is not None and not (integrated and c == "displacement")
    )
    if not channels:
        raise InputError(
            f"{record.name} has none of the channels that are declared smoothed, {', '.join(declaration.channels)}"
        )
    samples = _samples(record, declaration)
    rest = max(int(np.searchsorted(record.time, motion_start(record))) - samples, 0) if declaration.undo else 0
    if declaration.undo and declaration.samples is None:
        samples = _clearest(record, channels, samples, declaration.trailing, rest)
    before, after = reach_of(samples, declaration.trailing)
    alignment: Alignment = "trailing" if declaration.trailing else "centred"
    window = f"moving average of {samples} samples ({samples * record.dt:.4g} s, {alignment})"
    raw: dict[str, Array] = {}
    notes = []
    for channel in channels:
        reason = "declared so"
        if declaration.undo:
            values, reason = _raw(getattr(record, channel), channel, before, after, rest)
            if values is not None:
                raw[channel] = values
        notes.append(f"{channel}: {window} {'undone, ' if channel in raw else 'not undone, '}{reason}")
    changes: dict[str, Any] = dict(raw)
    stays = tuple(channel for channel in channels if channel not in raw)
    if integrated and "velocity" in raw:
        changes["displacement"] = integral(record.time, raw["velocity"])
        notes.append("displacement: integrated again from the raw velocity")
    elif integrated and "velocity" in stays:
        stays = ("displacement", *stays)
        notes.append("displacement: smoothed as the velocity that it is the integral of")
    left = MovingAverage(float(f"{samples * record.dt:.12g}"), alignment, stays) if stays else None
    if "displacement" in raw and left is not None and "velocity" in left.channels:
        changes["velocity"], left = None, left.without(("velocity",))
        notes.append("velocity: left out, since it stays smoothed and the displacement does not; it is derived")
    provenance = dict(record.provenance) | {PROVENANCE: f"{window}: {', '.join(channels)}"}
    for note in notes[:-1]:
        record = record.replace(note=note)
    return record.replace(note=notes[-1], smoothed=left, provenance=provenance, **changes)


def _samples(record: Record, declaration: Declaration) -> int:
    """The window in samples, as declared."""
    if declaration.samples is not None:
        samples = declaration.samples
    elif declaration.seconds is not None:
        samples = round(declaration.seconds / record.dt)
    else:
        assert declaration.periods is not None
        samples = round(declaration.periods * period(record) / record.dt)
    if not 2 <= samples <= record.n // 2:
        raise InputError(
            f"{record.name}: a window of {declaration.window} is {samples} samples of {record.dt:.4g} s; it must be from 2 to "
            f"{record.n // 2}, half of the record, so correct what is declared"
        )
    return samples


def period(record: Record) -> float:
    """The period of a motion that repeats itself, s, or an InputError."""
    if not cycle_bounds(record) or not repeats(record):
        raise InputError(
            f"{record.name}: its motion does not repeat itself, so that a window in periods is none; declare it in s or samples"
        )
    return 1.0 / fundamental(record)[0]


def _clearest(record: Record, channels: tuple[str, ...], samples: int, trailing: bool, rest: int) -> int:
    """``samples``, or one more or less where that window leaves far less noise in every channel."""

    def remaining_noise(size: int) -> Array:
        """Of each channel; infinite where the window cannot be undone."""
        noise = np.full(len(channels), np.inf)
        for k, channel in enumerate(channels):
            with suppress(InputError):
                undone = undo(getattr(record, channel), *reach_of(size, trailing), rest)
                noise[k] = np.hypot(undone.noise, undone.error)
        return noise

    declared, best = remaining_noise(samples), samples
    for size in (samples - 1, samples + 1):
        other = remaining_noise(size) if size >= 2 else np.full(len(channels), np.inf)
        if np.any(other < CLEARER * declared) and np.all(other < ALIKE * declared):
            declared, best = other, size
    return best


def _raw(values: Array, channel: str, before: int, after: int, rest: int) -> tuple[Array | None, str]:
    """The raw channel and how it was made, or None and why it cannot be."""
    unit = CHANNELS[channel]
    try:
        undone = undo(values, before, after, rest)
    except InputError as problem:
        return None, str(problem)
    if not undone.reliable:
        error = undone.error / undone.growth
        return None, (
            f"since the smoothed values hold an error of their own, such as rounding, of about {error:.2g} {unit}, which "
            f"grows {undone.growth:.3g}-fold to {undone.error:.2g} {unit} (noise {undone.noise:.2g} {unit}); export more digits"
        )
    if channel == "force" and not undone.complete:
        return None, (
            f"since about {undone.missing:.2g} {unit} rms of it repeats itself in each window, which the average has removed "
            "for good; a record that begins with two windows of rest would tell it"
        )
    how = f"start values from {undone.start}, errors of the smoothed values are multiplied by up to {undone.growth:.3g}"
    if undone.grid is not None:
        how += f" but for those that rounding to the converter's steps of {undone.grid:.4g} {unit} removed"
    if undone.missing > undone.noise:
        how += f"; about {undone.missing:.2g} {unit} rms that repeats itself in each window is lost"
    return undone.values, how


def force_average(record: Record) -> MovingAverage | None:
    """The moving average that a record's force still holds, or None."""
    return record.smoothed if record.smoothed is not None and "force" in record.smoothed.channels else None


def comparable(record: Record) -> slice:
    """The samples of a record whose force can be compared with a model's: all, or those with whole windows."""
    average = force_average(record)
    return slice(0, record.n) if average is None else whole_windows(record.n, *average.reach(record.dt))
