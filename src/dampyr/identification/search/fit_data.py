"""The data of a fit: records as arrays, from where their motion starts."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.records import Record, cycle_bounds, with_velocity
from dampyr.records.checks.quality import motion_start
from dampyr.records.conditioning.moving_average import whole_windows
from dampyr.records.conditioning.nominal_input import Commanded, commanded_input, in_common
from dampyr.records.conditioning.smoothing import force_average
from dampyr.records.record_cache import cached_by_record

Array = NDArray[np.float64]
MOTION_SHARE = 0.9  # of the range of displacement and velocity: a part of a record that represents the whole
MIN_SAMPLES = 16  # after the motion starts: of fewer no cycle of a loop can be seen


@dataclass(frozen=True)
class Piece:
    """One record from where its motion starts: arrays (n,), the input, and the cluster of each sample.

    ``weight`` is of each sample, or one for all, (1,); ``spread`` the standard deviation of the compared force, N.
    ``second_weight`` is the weight by the second derivative of a loss that is not squares (see
    `dampyr.identification.search.robust`). ``average`` is how many samples before and after each one a moving average of the
    measured force takes in, None where it is not smoothed; ``smoothed_motion`` says that the displacement is smoothed, in s
    of the window, else 0. ``temperature`` is the mean of the record's, degC. ``cut_from`` names the record that it
    is a piece of, itself where it is whole. ``commanded`` is the command behind an input that varies and has noise
    (`dampyr.records.conditioning.nominal_input.commanded_input`), to whose ends ``u`` is held.
    """

    name: str
    t: Array
    x: Array
    v: Array
    force: Array
    u: Array | float
    weight: Array
    spread: float
    cycle: NDArray[np.int64]
    unit: str
    second_weight: Array | None = None
    temperature: float = math.nan
    average: tuple[int, int] | None = None
    smoothed_motion: float = 0.0
    cut_from: str = ""
    commanded: Commanded | None = None

    @property
    def levels(self) -> Array | float:
        """The inputs that a law may have its ends and knots at: those that were commanded."""
        return self.u if self.commanded is None else self.commanded.levels

    @property
    def comparable(self) -> slice:
        """The samples whose measured force can be compared with a model's: all, or those with whole windows."""
        return slice(0, self.t.size) if self.average is None else whole_windows(self.t.size, *self.average)

    @property
    def count(self) -> int:
        """How many samples are compared: all, or those with whole windows."""
        return self.comparable.stop - self.comparable.start

    @property
    def shortest(self) -> int:
        """How many samples a part of it needs at least: four windows, where only whole ones count."""
        return 0 if self.average is None else 4 * (sum(self.average) + 1)

    def part(self, samples: slice) -> Piece:
        """Some of its samples: the first ones, or every k-th."""
        t, x, v, force = (np.ascontiguousarray(a[samples]) for a in (self.t, self.x, self.v, self.force))
        u = self.u[samples] if np.ndim(self.u) else self.u  # type: ignore[index]
        weight, second_weight = self.weight, self.second_weight
        if weight.size > 1:
            weight = np.ascontiguousarray(weight[samples])
        if second_weight is not None:
            second_weight = np.ascontiguousarray(second_weight[samples])
        return replace(
            self, t=t, x=x, v=v, force=force, u=u, weight=weight, cycle=self.cycle[samples], second_weight=second_weight
        )

    @property
    def ends(self) -> NDArray[np.int64]:
        """Where each cluster of samples ends."""
        return np.append(np.flatnonzero(np.diff(self.cycle)) + 1, self.t.size)


@cached_by_record  # a search of models, and every part that is left out, takes the same records
def piece(record: Record, bandwidth: float | None) -> Piece:
    """A record as arrays: velocity as recorded or derived, weight 1 over the force's standard deviation."""
    if record.input is None:
        raise InputError(unknown_input(record.name))
    if record.velocity is None or bandwidth is not None:
        record = with_velocity(record, bandwidth)
    assert record.velocity is not None
    first = int(np.searchsorted(record.time, motion_start(record)))
    average = force_average(record)
    reach = None if average is None else average.reach(record.dt)
    if record.n - first < MIN_SAMPLES + sum(reach or (0,)):
        raise InputError(f"{record.name}: it holds no motion, so there is nothing to identify; check the displacement")
    window = slice(first, None)
    force = record.force[window]
    compared = force if reach is None else force[whole_windows(force.size, *reach)]
    spread = float(np.std(compared))
    if spread <= 1e-9 * max(1.0, float(np.max(np.abs(force)))):
        raise InputError(f"{record.name}: the force is constant at {force[0]:g} N; check the load cell's channel")
    u = 0.0 if record.input_channel is None else record.input_channel
    varies = np.ndim(u) > 0 and float(np.ptp(u)) > 1e-9  # else a channel that only repeats one number, to rounding
    u_of_fit: Array | float = np.asarray(u)[window] if varies else float(np.mean(u))
    commanded = commanded_input(np.asarray(u_of_fit)) if varies else None
    if commanded is not None:
        one_level = commanded.low == commanded.high
        u_of_fit = commanded.low if one_level else np.clip(u_of_fit, commanded.low, commanded.high)
    return Piece(
        name=record.name,
        t=np.ascontiguousarray(record.time[window]),
        x=np.ascontiguousarray(record.displacement[window]),
        v=np.ascontiguousarray(record.velocity[window]),
        force=np.ascontiguousarray(force),
        u=u_of_fit,
        weight=np.array([1.0 / spread]),
        spread=spread,
        cycle=_number_cycles(record)[window],
        unit=str(record.input),
        temperature=math.nan if record.temperature is None else float(np.mean(record.temperature)),
        average=reach,
        smoothed_motion=average_of_motion(record),
        cut_from=record.provenance.get("piece_of", record.name),
        commanded=commanded if np.ndim(u_of_fit) else None,
    )


def unknown_input(name: str) -> str:
    """What a record, or records, lack whose input nobody stated; that a damper has none is not guessed (decision 63)."""
    return (
        f"{name}: its voltage is not known; read it with voltage= (or current=); "
        "a damper without an input (friction, oil, rubber) is read with no_input=True"
    )


def with_common_levels(pieces: list[Piece]) -> list[Piece]:
    """The pieces with plateaus of their inputs that agree at the same levels, so that no law follows the difference."""
    noisy = [k for k, piece in enumerate(pieces) if piece.commanded is not None]
    stated = [float(piece.u) for piece in pieces if not np.ndim(piece.u)]
    levelled = list(pieces)
    for k, command in zip(noisy, in_common([pieces[k].commanded for k in noisy], stated), strict=True):  # type: ignore[misc]
        levelled[k] = replace(pieces[k], commanded=command, u=np.clip(pieces[k].u, command.low, command.high))
    return levelled


def average_of_motion(record: Record) -> float:
    """The window in s of the moving average that a record's displacement still holds, 0 where it holds none."""
    smoothed = record.smoothed
    return smoothed.window if smoothed is not None and "displacement" in smoothed.channels else 0.0


def weighted(pieces: list[Piece], weighting: str) -> list[Piece]:
    """The pieces with the weight of their records: see ``weighting`` of `dampyr.identification.fit`."""
    if weighting == "samples":
        return pieces
    mean = sum(piece.count for piece in pieces) / len(pieces)
    return [replace(piece, weight=piece.weight * np.sqrt(mean / piece.count)) for piece in pieces]


def _number_cycles(record: Record) -> NDArray[np.int64]:
    """Which cycle each sample belongs to; what comes before and after joins the nearest."""
    starts = np.array([i0 for i0, _ in cycle_bounds(record)], dtype=int)
    if starts.size == 0:
        return np.zeros(record.n, dtype=np.int64)
    return np.maximum(np.searchsorted(starts, np.arange(record.n), side="right") - 1, 0).astype(np.int64)


def thinned(piece: Piece, samples: int) -> Piece:
    """Every k-th sample of a record, so that at most ``samples`` are left; all where a moving average counts them."""
    k = -(-piece.t.size // samples)
    if k < 2 or piece.average is not None:
        return piece
    return piece.part(slice(None, None, k))


def first_part(piece: Piece, samples: int) -> Piece:
    """The first ``samples`` of a record, twice as many and so on until they hold nearly its whole motion; at most all."""
    whole = np.array([np.ptp(piece.x), np.ptp(piece.v)])
    n = max(samples, piece.shortest)
    while n < piece.t.size and np.any(np.array([np.ptp(piece.x[:n]), np.ptp(piece.v[:n])]) < MOTION_SHARE * whole):
        n *= 2
    return piece if n >= piece.t.size else piece.part(slice(n))
