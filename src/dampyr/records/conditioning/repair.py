"""Repairs of samples: false ones, gaps, and a zero that drifts. Each is a step that is told and that can be undone.

A record is never repaired unasked. The record keeps what each repair changed as it was before (`Record.repairs`), also in its
``.h5`` file, so that `undo_repairs` gives the measured samples back, bit by bit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from dampyr.errors import InputError
from dampyr.phrases import counted
from dampyr.records.checks.quality import quality, spikes
from dampyr.records.conditioning.drift import drift
from dampyr.records.conditioning.repair_step import REPAIR_KINDS, RepairStep, as_repairs
from dampyr.records.cycle_analysis.cycles import cycle_bounds, mean_over_time, require_cycles
from dampyr.records.record import CHANNELS, Array, Record

PASSES = 5  # a false sample hides the one beside it from the running median
SHORT_GAP = 3  # missing samples, or
GAP_OF_CYCLE = 0.05  # of the shortest cycle: 18 degrees, over which a loop is nearly straight, but at a reversal
MANY = 0.005  # of the samples that are not measured: a fit's numbers may rest on them


def repair(record: Record, kinds: str) -> Record:
    r"""The record with samples repaired, each repair a step that `undo_repairs` takes back.

    Parameters
    ----------
    kinds
        One or several, with commas between them:

        ``"false samples"``
            samples of displacement and force that leap away from their neighbours and back (`dampyr.records.quality`) are
            replaced by what lies between the nearest samples that do not, linearly in time. They are found where they are
            fewer than one in a hundred.
        ``"gaps"``
            where samples are missing (an interval over 1.5 times the median, or the threshold ``gap``), they are put in at
            the median interval, on a monotone cubic through the samples about the gap (Fritsch and Carlson 1980), which does
            not leave the range of its ends. A gap of over three samples that is longer than a twentieth of the shortest
            cycle is refused: what the damper did in it is not known.
        ``"force drift"``
            the zero of the force that drifts: the least-squares line through the mean forces of the whole cycles, less its
            value at the first sample, is taken off. Gas that warms up looks alike.
        ``"position drift"``
            as `dampyr.records.remove_drift`: the drift of the mean position is taken off the displacement, its slope off the
            velocity. The damper did feel it: good for comparing loops, and not for a fit.

    Returns
    -------
    Record
        Its findings say what was repaired, its history also of which kind nothing was found.

    Raises
    ------
    InputError
        An unknown kind, a gap that is too long, or no whole cycle to see a drift in.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> force = 50.0 * np.cos(6 * t)
    >>> force[300] = 3000.0
    >>> record = dp.records.Record(t, 0.01 * np.sin(6 * t), force, no_input=True)
    >>> repaired = dp.records.repair(record, "false samples")
    >>> print(round(float(repaired.force[300]), 1), round(50 * np.cos(6 * 1.5), 1))
    -45.5 -45.6
    >>> bool(np.all(dp.records.undo_repairs(repaired).force == force))
    True
    """
    for kind in as_repairs(kinds):
        repaired = _REPAIRS[kind](record)
        record = record.replace(note=f"{kind}: nothing to repair was found") if repaired is record else repaired
    return record


def undo_repairs(record: Record, kinds: str | None = None) -> Record:
    """The record as it was before its repairs, or before those of some kinds; the samples are those that were measured.

    Samples that were cut away since stay away.

    Raises
    ------
    InputError
        A channel was changed after the repair, as by a low-pass: read the file again without the repair.
    """
    wanted = REPAIR_KINDS if kinds is None else as_repairs(kinds)
    for step in reversed(record.repairs):
        if step.kind in wanted:
            record = _without(record, step)
    return record


def remove_drift(record: Record) -> Record:
    """The record with the line of its drift taken from the displacement (and its slope from the velocity).

    The damper did feel the drift: use this to compare loops, not to fit a model to them. It is `repair` of "position drift".
    """
    return repair(record, "position drift")


def _false_samples(record: Record) -> Record:
    for channel in ("displacement", "force"):
        measured: Array = getattr(record, channel)
        mended, false = measured, np.zeros(record.n, dtype=bool)
        for _ in range(PASSES):
            found = spikes(mended, record.thresholds.false_sample)
            if not len(found):
                break
            false[found] = True
            good = ~false
            mended = np.where(false, np.interp(record.time, record.time[good], measured[good]), measured)
        if false.any():
            words = f"{counted(int(false.sum()), 'false sample')} of the {channel} replaced, linearly between their neighbours"
            record = _changed(record, "false samples", {channel: mended}, words)
    return record


def _gaps(record: Record) -> Record:
    from scipy.interpolate import PchipInterpolator

    report = quality(record)
    if report.is_uneven:
        raise InputError(
            f"{record.name}: the time stamps jitter, so that no sample is missing that could be put in; read the file with the "
            f"interval of its samples, --dt {report.mean_interval:.4g} or dt={report.mean_interval:.4g}"
        )
    steps = np.diff(record.time)
    at = np.flatnonzero(steps > record.thresholds.gap * record.dt)
    if not len(at):
        return record
    missing = np.maximum(1, np.rint(steps[at] / record.dt).astype(int) - 1)
    _check_lengths(record, at, missing)
    new = np.concatenate(
        [np.linspace(record.time[k], record.time[k + 1], n + 2)[1:-1] for k, n in zip(at, missing, strict=True)]
    )
    place = np.searchsorted(record.time, new)
    held = {name: values for name in CHANNELS if isinstance(values := getattr(record, name), np.ndarray)}
    added: dict[str, Array] = {
        name: PchipInterpolator(record.time, values)(new) for name, values in held.items() if name != "time"
    }
    whole = {name: np.insert(values, place, added.get(name, new)) for name, values in held.items()}
    words = (
        f"{counted(len(new), 'sample')} put into {counted(len(at), 'gap')}, the longest of {float(steps[at].max()):.3g} s, on "
        "a monotone cubic through the samples about it"
    )
    step = RepairStep("gaps", new, {name: np.full(len(new), np.nan) for name in added}, added, words)
    return record.replace(note=words, **whole, repairs=(*record.repairs, step))


def _check_lengths(record: Record, at: Any, missing: Any) -> None:
    """Raise where a gap is too long for what the damper did in it to be known from its ends."""
    spans = cycle_bounds(record)
    shortest = min((float(record.time[i1] - record.time[i0]) for i0, i1 in spans), default=0.0)
    limit = max((SHORT_GAP + 1) * record.dt, GAP_OF_CYCLE * shortest)
    lengths = record.time[at + 1] - record.time[at]
    long = np.flatnonzero((lengths > limit * (1.0 + 1e-6)) & (missing > SHORT_GAP))  # a millionth: times are rounded
    if len(long):
        k = long[0]
        raise InputError(
            f"{record.name}: the gap of {lengths[k]:.4g} s at {record.time[at[k]]:.4g} s is too long to be filled, at most "
            f"{limit:.4g} s here (three samples or a twentieth of the shortest cycle); cut the record there, or record it again"
        )


def _force_drift(record: Record) -> Record:
    spans = require_cycles(record, "the drift of the force")
    if len(spans) < 2:
        raise InputError(f"{record.name}: one whole cycle shows no drift of the force; record two or more")
    # the middle of a cycle's span, for its mean holds for that time
    at = np.array([0.5 * (record.time[i0] + record.time[i1]) for i0, i1 in spans])
    means = np.array([mean_over_time(record.force, record, i0, i1) for i0, i1 in spans])
    slope = float(np.polyfit(at - at.mean(), means, 1)[0])
    line = slope * (record.time - record.time[0])
    words = f"drift of the force's zero, {slope:.4g} N/s, taken off: {line[-1]:.4g} N over the record"
    return _changed(record, "force drift", {"force": record.force - line}, words)


def _position_drift(record: Record) -> Record:
    slope = drift(record)
    changed = {"displacement": record.displacement - slope * (record.time - record.time[0])}
    if record.velocity is not None:
        changed["velocity"] = record.velocity - slope
    words = (
        f"drift of {1e3 * slope:.4g} mm/s removed from the displacement; the damper did feel it: compare loops, and fit the "
        "record without this repair"
    )
    return _changed(record, "position drift", changed, words)


_REPAIRS: Mapping[str, Callable[[Record], Record]] = dict(
    zip(REPAIR_KINDS, (_false_samples, _gaps, _force_drift, _position_drift), strict=True)
)


def _changed(record: Record, kind: str, channels: Mapping[str, Array], words: str) -> Record:
    """The record with these channels; what they were, where they differ, is kept in the step."""
    apart = np.zeros(record.n, dtype=bool)
    for name, values in channels.items():
        apart |= values != getattr(record, name)
    if not apart.any():
        return record
    before = {name: getattr(record, name)[apart] for name in channels}
    after = {name: values[apart] for name, values in channels.items()}
    step = RepairStep(kind, record.time[apart], before, after, words)
    return record.replace(note=words, **channels, repairs=(*record.repairs, step))


def _without(record: Record, step: RepairStep) -> Record:
    """The record before one repair, whose samples must still be what it made of them."""
    place = np.searchsorted(record.time, step.time).clip(max=record.n - 1)
    there = record.time[place] == step.time
    at = place[there]
    channels: dict[str, Array] = {}
    for name, after in step.after.items():
        values = getattr(record, name)
        if not isinstance(values, np.ndarray) or not np.array_equal(values[at], after[there]):
            raise InputError(
                f"{record.name}: the {name} was changed after the repair of {step.kind}, which cannot be undone any more; read "
                "the file again without repair"
            )
        channels[name] = np.array(values)
        channels[name][at] = step.before[name][there]
    if step.added:
        held = {name: values for name in CHANNELS if isinstance(values := getattr(record, name), np.ndarray)}
        channels = {name: np.delete(values, at) for name, values in held.items()}
    left = tuple(other for other in record.repairs if other is not step)
    return record.replace(note=f"undone: {step.words}", **channels, repairs=left)


def repair_sentences(record: Record) -> tuple[list[str], list[str]]:
    """What was repaired in a record: what is a doubt, as so many samples are not measured, and what is good to know."""
    doubts: list[str] = []
    notes: list[str] = []
    for step in record.repairs:
        share = float(np.isin(step.time, record.time).sum()) / record.n
        drifted = step.kind.endswith("drift")
        doubtful = step.kind == "position drift" if drifted else share > MANY
        (doubts if doubtful else notes).append(step.words)
    return doubts, notes


def as_stated(record: Record, kinds: str) -> Record:
    """The record as its reader wants it: repaired, or, with "none", without the repairs that its file holds."""
    return repair(record, kinds) if as_repairs(kinds) else undo_repairs(record)
