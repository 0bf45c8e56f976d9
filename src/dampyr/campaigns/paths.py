r"""Pieces of a table's path, each beginning and ending at rest, and their set points.

Swing: a sine of whole cycles whose first and last ``taper`` cycles grow and fade as a raised cosine,

.. math:: x = x_0 + A\, g \sin 2 \pi f t, \qquad g = \tfrac12 (1 - \cos \pi f t / m) \text{ over the first } m \text{ cycles}

so that position and speed are continuous and the acceleration begins at 0; the speed stays below :math:`2 \pi f A`.
Move: from one place to another at a constant speed reached and left in ``RAMP`` seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.rig import Drive

Array = NDArray[np.float64]
RAMP = 0.1  # s from rest to a constant speed
GLIDE = 0.010  # m/s from the middle to a test's centre and back
AFTER = 0.5  # s of rest after a test
MAX_DURATION = 36_000.0  # s of a path that is worth drawing; the check of a test is stricter


@dataclass(frozen=True)
class PathPiece:
    """A stretch of path: its length [s] and the position [m] (n,) at times (n,) from its begin."""

    duration: float
    at: Callable[[Array], Array]


def hold(place: float, seconds: float) -> PathPiece:
    """Rest at ``place`` [m]."""
    return PathPiece(seconds, lambda t: np.full(t.shape, place))


def swing(amplitude: float, frequency: float, cycles: int, taper: int, centre: float = 0.0) -> PathPiece:
    """``cycles`` steady cycles, and ``taper`` cycles more on either side (see above)."""
    duration = (cycles + 2 * taper) / frequency

    def at(t: Array) -> Array:
        grown = raised(t * frequency / taper) * raised((duration - t) * frequency / taper)
        return centre + amplitude * grown * np.sin(2 * math.pi * frequency * t)

    return PathPiece(duration, at)


def raised(share: Array) -> Array:
    """The raised cosine from 0 at ``share`` 0 to 1 at 1 and beyond."""
    return 0.5 * (1 - np.cos(math.pi * np.clip(share, 0.0, 1.0)))


def top_speed(distance: float, speed: float) -> float:
    """The greatest speed [m/s] of a move: ``speed``, or less where it is too short for it."""
    # Half of the distance at the acceleration speed/RAMP: v^2 = 2 a d/2.
    return min(speed, math.sqrt(abs(distance) * speed / RAMP))


def move(start: float, stop: float, speed: float) -> PathPiece:
    """From ``start`` to ``stop`` [m] at ``speed`` [m/s], with a constant acceleration speed/RAMP at either end."""
    distance, a = abs(stop - start), speed / RAMP
    top = top_speed(distance, speed)
    ramp = top / a
    duration = distance / top + ramp if distance else 0.0

    def at(t: Array) -> Array:
        t = np.clip(t, 0.0, duration)
        ends = np.where(t < ramp, 0.5 * a * t**2, distance - 0.5 * a * (duration - t) ** 2)
        travelled = np.where((t >= ramp) & (t <= duration - ramp), top * (t - 0.5 * ramp), ends)
        return start + math.copysign(1.0, stop - start) * travelled

    return PathPiece(duration, at)


def moves(places: Sequence[float], speed: float, pause: float = 0.0) -> Iterator[PathPiece]:
    """Moves from each place to the next, with ``pause`` seconds of rest after each."""
    for start, stop in pairwise(places):
        yield move(start, stop, speed)
        if pause:
            yield hold(stop, pause)


def around(pieces: Sequence[PathPiece], centre: float, rest_before: float) -> list[PathPiece]:
    """Rest in the middle, a glide to the ``centre``, the pieces, the glide back and ``AFTER`` seconds of rest."""
    out, back = ([move(0.0, centre, GLIDE)], [move(centre, 0.0, GLIDE)]) if centre else ([], [])
    return [hold(0.0, rest_before), *out, *pieces, *back, hold(0.0, AFTER)]


def start_of(centre: float, rest_before: float) -> float:
    """s from the begin of a path `around` its pieces to the first of them."""
    return rest_before + move(0.0, centre, GLIDE).duration


def sampled(pieces: Sequence[PathPiece], period: float) -> Array:
    """The positions at 0, period, 2 period ...; the last set point is at or after the end, and at rest."""
    edges = np.concatenate(([0.0], np.cumsum([piece.duration for piece in pieces])))
    if edges[-1] > MAX_DURATION:
        raise InputError(
            f"the path takes {edges[-1] / 60:.4g} min, at most {MAX_DURATION / 60:g} min are drawn; shorten it"
        )
    # 1e-9 of a period: a path of whole periods gets no further set point by a rounding error.
    t = np.arange(math.ceil(edges[-1] / period - 1e-9) + 1) * period
    which = np.clip(np.searchsorted(edges, t, side="right") - 1, 0, len(pieces) - 1)
    x = np.empty(t.size)
    for k, piece in enumerate(pieces):
        inside = which == k
        x[inside] = piece.at(np.minimum(t[inside] - edges[k], piece.duration))
    return x


def driven(pieces: Sequence[PathPiece], period: float, voltage: float) -> Drive:
    """The drive along the pieces at a constant voltage [V]."""
    x = sampled(pieces, period)
    return Drive(period, x, np.full(x.size, voltage))


def stepwise(
    pieces: Sequence[PathPiece], period: float, begin: float, levels: Sequence[float], hold_for: float
) -> Drive:
    """The drive along the pieces; from ``begin`` [s] each of the ``levels`` [V] for ``hold_for`` seconds, else 0 V."""
    x = sampled(pieces, period)
    slot = np.floor((np.arange(x.size) * period - begin) / hold_for + 1e-9).astype(int)
    inside = (slot >= 0) & (slot < len(levels))
    return Drive(period, x, np.where(inside, np.asarray(levels)[np.clip(slot, 0, len(levels) - 1)], 0.0))
