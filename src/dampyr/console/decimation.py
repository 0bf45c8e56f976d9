"""Data of the live charts: bins of 10 ms whatever the sampling rate, with the least and the greatest value of each.

No peak is lost, and a page gets as much in a second from a board at 10 kHz as from one at 1 kHz.
"""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from dampyr.models.numerics.differentiation import differentiate, window
from dampyr.records.conditioning.velocity import WITHOUT_CYCLES
from dampyr.rig.interlock import Samples

Array = NDArray[np.float64]
BINS = 100  # per second
HISTORY = 60.0  # s that a page can look back
BANDWIDTH = 10.0  # Hz of the velocity: a raw difference of the encoder's counts is a staircase where the table turns
COLUMNS = {  # what a bin holds, its unit on the page, the factor from SI, and its decimals
    "time": ("s", 1.0, 3),
    "x_low": ("mm", 1e3, 4),
    "x_high": ("mm", 1e3, 4),
    "force_low": ("N", 1.0, 2),
    "force_high": ("N", 1.0, 2),
    "voltage_low": ("V", 1.0, 4),
    "voltage_high": ("V", 1.0, 4),
    "temperature": ("degC", 1.0, 3),
    "velocity": ("mm/s", 1e3, 2),
    "x_first": ("mm", 1e3, 4),
    "force_first": ("N", 1.0, 2),
    "x_second": ("mm", 1e3, 4),
    "force_second": ("N", 1.0, 2),
    "target": ("mm", 1e3, 4),
}
_FACTOR = np.array([factor for _, factor, _ in COLUMNS.values()])


class MinMaxBins:
    """The last bins of a rig, numbered from 0; filled by one thread and read by any.

    The velocity is that of the bin `lag` bins before, as a record has it: the slope of local cubics, without phase, 3 dB down
    at `BANDWIDTH`; it needs what comes after it. ``first`` and ``second`` are a bin's samples of least and greatest force in
    the order of their time, of which loops are drawn; ``target`` is what a drive asks for in its middle. nan stands where
    there is nothing, and a bin of it where sampling began anew.
    """

    def __init__(self, rate: float, begin: float = 0.0) -> None:
        self.size = max(1, round(rate / BINS))
        self.width = self.size / rate
        self._slope = _slope(self.width)
        self.lag = len(self._slope) // 2
        """Bins by which the velocity comes later than the bin that it is of."""
        self.count = 0  # bins so far
        self.time = begin  # s at the end of the last sample
        self._rate, self._next = rate, -1
        self._rest, self._means = np.empty((5, 0)), np.empty(0)
        self._ring = np.full((round(HISTORY / self.width), len(COLUMNS)), np.nan)
        self._lock = threading.Lock()

    def take(self, samples: Samples, temperature: float, now: float) -> None:
        """Sort a block into bins; ``now`` [s] is the time at which a new run of samples begins."""
        if samples.first != self._next:
            self._begin(now)
        self._next = samples.first + samples.n
        target = np.full(samples.n, np.nan) if samples.target is None else samples.target
        new = np.array([
            np.arange(samples.n) / self._rate, samples.displacement, samples.force, samples.voltage, target,
        ])  # fmt: skip
        new[0] += self.time
        self.time += samples.n / self._rate
        rows = np.concatenate([self._rest, new], axis=1)
        whole = rows.shape[1] // self.size * self.size
        self._rest = rows[:, whole:]
        if whole:
            self._add(rows[:, :whole].reshape(5, -1, self.size), temperature)

    def since(self, number: int) -> tuple[int, Array]:
        """The bins from ``number`` on that are still known, in units of the page, and the number of the next one."""
        with self._lock:
            first = max(number, self.count - len(self._ring), 0)
            places = np.arange(first, self.count) % len(self._ring)
            return self.count, self._ring[places] * _FACTOR

    def _begin(self, now: float) -> None:
        """A new run: a gap stands before it."""
        if self.count:
            gap = np.full((1, len(COLUMNS)), np.nan)
            gap[0, 0] = max(now, self.time)
            self._store(gap)
        self.time = max(now, self.time)
        self._rest, self._means = np.empty((5, 0)), np.empty(0)

    def _add(self, bins: Array, temperature: float) -> None:
        """``bins`` is (5, bins, samples)."""
        time, x, force, voltage, target = bins
        low, high = force.argmin(axis=1), force.argmax(axis=1)
        row = np.arange(len(low))
        first, second = np.minimum(low, high), np.maximum(low, high)
        self._store(np.column_stack([
            time[:, 0], x.min(axis=1), x.max(axis=1), force[row, low], force[row, high],
            voltage.min(axis=1), voltage.max(axis=1), np.full(len(low), temperature), self._velocity(x.mean(axis=1)),
            x[row, first], force[row, first], x[row, second], force[row, second], target[:, self.size // 2],
        ]))  # fmt: skip

    def _velocity(self, means: Array) -> Array:
        """Of the bins `lag` before these, whose mean positions are ``means``; nan until there are enough of them."""
        held = np.concatenate([self._means, means])
        self._means = held[-2 * self.lag :]
        velocity = np.full(len(means), np.nan)
        if (n := len(held) - 2 * self.lag) > 0:
            velocity[-n:] = np.convolve(held, self._slope, mode="valid")
        return velocity

    def _store(self, rows: Array) -> None:
        with self._lock:
            places = np.arange(self.count, self.count + len(rows)) % len(self._ring)
            self._ring[places] = rows
            self.count += len(rows)


def _slope(width: float) -> Array:
    """What the means of bins of ``width`` [s] are convolved with to give the velocity: the answer of a record's filter to 1."""
    bandwidth = min(BANDWIDTH, WITHOUT_CYCLES / width)
    reach = window(width, bandwidth)[1]
    unit = np.zeros(8 * reach + 1)
    unit[4 * reach] = 1.0
    return differentiate(width * np.arange(unit.size, dtype=np.float64), unit, bandwidth)[3 * reach : 5 * reach + 1]


def as_lists(rows: Array) -> dict[str, list[float | None]]:
    """Bins by their names, rounded to what a page shows; None stands for nan, which JSON has not."""
    columns: dict[str, list[float | None]] = {}
    for (name, (_, _, digits)), column in zip(COLUMNS.items(), rows.T, strict=True):
        values = np.round(column, digits)
        columns[name] = (
            values.tolist() if np.isfinite(values).all() else [v if v == v else None for v in values.tolist()]
        )
    return columns
