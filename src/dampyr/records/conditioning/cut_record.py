"""One long record as several: in pieces of equal duration, or at the rests between events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.records.checks.channel_noise import rest_tolerance
from dampyr.records.record import MIN_SAMPLES, Array, Record, commonest_name
from dampyr.units import parse

EVENTS = "events"
REST = 1.0  # s: at the turning point of a slow sine, 2 mm at 0.05 Hz, it moves 25 um in it; an encoder of 5 um allows 15 um


def cut(record: Record, by: float | str, rest: float = REST) -> list[Record]:
    """A record in pieces that follow on one another; together they hold every sample once.

    Parameters
    ----------
    by
        A duration in s, or a text such as ``"5 s"``: pieces of that duration from the first sample on; what is left at the
        end is a piece of its own where it lasts at least half as long, else part of the last one. Or ``"events"``: cut in the
        middle of every rest between two motions.
    rest
        With ``"events"``: the table is at rest where, for ``rest`` s or longer, the displacement strays by no more than twice
        what it does at rest: 1.5 steps of its encoder, or 4 deviations of its noise.

    Time stays the record's. The pieces are called NAME_1, NAME_2, ... with leading zeros; session, specimen, role and label
    are the record's; history and provenance (``piece``, ``piece_of``) say which piece of what each is. A record that is not
    longer than ``by``, or has no rest between two motions, comes back alone and as it is.

    Raises
    ------
    InputError
        ``by`` is neither a duration nor "events", ``rest`` is not a duration, or a piece would have fewer than 8 samples.
    """
    if by == EVENTS:
        if not (math.isfinite(rest) and rest > 0.0):
            raise InputError(f"rest = {rest:g} s is not allowed; it must be finite and greater than 0")
        edges, how = _in_rests(record, rest), f"at rests of {rest:g} s or more"
    else:
        duration = _duration(by)
        edges, how = _every(record, duration), f"every {duration:g} s"
    if len(edges) == 2:
        return [record]
    few = [k for k in range(len(edges) - 1) if edges[k + 1] - edges[k] < MIN_SAMPLES]
    if few:
        raise InputError(
            f"{record.name}: cut {how}, a piece would have {edges[few[0] + 1] - edges[few[0]]} samples and needs "
            f"{MIN_SAMPLES}; give a longer duration"
        )
    return [_piece(record, slice(edges[k], edges[k + 1]), k + 1, len(edges) - 1, how) for k in range(len(edges) - 1)]


def cut_all(records: Sequence[Record], by: float | str) -> list[Record]:
    """The pieces of several records, each cut as by `cut`; :class:`~dampyr.errors.InputError` where two have one name."""
    pieces = [piece for record in records for piece in cut(record, by)]
    name, count = commonest_name(pieces)
    if count > 1:
        raise InputError(f"{count} records or pieces are called {name!r}; rename a file, or read them without cut")
    return pieces


def check_cut(by: float | str) -> None:
    """Raise :class:`~dampyr.errors.InputError` unless ``by`` is a duration or "events"."""
    if by != EVENTS:
        _duration(by)


def _duration(by: float | str) -> float:
    try:
        duration = parse(by, "s")
    except InputError:
        raise InputError(f"cut by {by!r} is not possible; give a duration such as '5 s', or '{EVENTS}'") from None
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(f"cut by {duration:g} s is not possible; a duration must be finite and greater than 0")
    return duration


def _every(record: Record, duration: float) -> list[int]:
    """Sample numbers of the pieces' beginnings, and of the end."""
    # a millionth of a step early: a sample at 5 s begins the second piece of 5 s however its time was rounded
    starts = record.time[0] + duration * np.arange(max(1, math.ceil(record.duration / duration))) - 1e-6 * record.dt
    edges = [*np.unique(np.searchsorted(record.time, starts)).tolist(), record.n]
    if len(edges) > 2 and record.time[-1] - record.time[edges[-2]] + record.dt < 0.5 * duration:
        del edges[-2]
    return edges


def _in_rests(record: Record, rest: float) -> list[int]:
    """As `_every`, cut in the middle of each rest that lies between two motions."""
    still = _still(record.time, record.displacement, rest)
    changes = np.flatnonzero(np.diff(still)) + 1
    bounds = [0, *changes.tolist(), record.n]
    inner = [(i0, i1) for i0, i1 in pairwise(bounds) if still[i0] and i0 > 0 and i1 < record.n]
    return [0, *((i0 + i1) // 2 for i0, i1 in inner), record.n]


def _still(time: Array, x: Array, rest: float) -> NDArray[np.bool_]:
    """Whether each sample lies in a stretch of ``rest`` s or more within which ``x`` stays within the tolerance of a rest."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    width = max(2, round(rest / float(np.median(np.diff(time)))) + 1)
    if width > x.size:
        return np.zeros(x.size, dtype=bool)
    # window k holds the samples k to k + width - 1
    origin = -(width // 2)
    high = maximum_filter1d(x, width, mode="nearest", origin=origin)[: x.size - width + 1]
    low = minimum_filter1d(x, width, mode="nearest", origin=origin)[: x.size - width + 1]
    quiet = np.flatnonzero(high - low <= 2.0 * rest_tolerance(x))
    marks = np.zeros(x.size + 1, dtype=int)
    np.add.at(marks, quiet, 1)
    np.add.at(marks, quiet + width, -1)
    return np.cumsum(marks[:-1]) > 0


def _piece(record: Record, window: slice, number: int, count: int, how: str) -> Record:
    place = f"{number} of {count}"
    start, end = record.time[window][[0, -1]]
    return record.sliced(
        window,
        note=f"piece {place} of {record.name}, {start:.6g} to {end:.6g} s, cut {how}",
        name=f"{record.name}_{number:0{len(str(count))}d}",
        provenance=dict(record.provenance) | {"piece_of": record.name, "piece": place},
    )
