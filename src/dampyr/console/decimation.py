"""Data of the live charts: bins of 10 ms whatever the sampling rate, with the least and the greatest value of each.

No peak is lost, and a page gets as much in a second from a board at 10 kHz as from one at 1 kHz.
"""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from dampyr.rig.interlock import Samples

Array = NDArray[np.float64]
BINS = 100  # per second
HISTORY = 30.0  # s that a page can look back
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
}
_FACTOR = np.array([factor for _, factor, _ in COLUMNS.values()])


class MinMaxBins:
    """The last bins of a rig, numbered from 0; filled by one thread and read by any.

    A bin's velocity is that of the mean positions of its neighbours; ``first`` and ``second`` are its samples of least and
    greatest force in the order of their time, of which loops are drawn. A bin of nan stands where sampling began anew.
    """

    def __init__(self, rate: float, begin: float = 0.0) -> None:
        self.size = max(1, round(rate / BINS))
        self.width = self.size / rate
        self.count = 0  # bins so far
        self.time = begin  # s at the end of the last sample
        self._rate, self._next = rate, -1
        self._rest, self._held = np.empty((4, 0)), np.empty((0, len(COLUMNS)))
        self._means = np.empty(0)
        self._ring = np.full((round(HISTORY / self.width), len(COLUMNS)), np.nan)
        self._lock = threading.Lock()

    def take(self, samples: Samples, temperature: float, now: float) -> None:
        """Sort a block into bins; ``now`` [s] is the time at which a new run of samples begins."""
        if samples.first != self._next:
            self._begin(now)
        self._next = samples.first + samples.n
        new = np.array([np.arange(samples.n) / self._rate, samples.displacement, samples.force, samples.voltage])
        new[0] += self.time
        self.time += samples.n / self._rate
        rows = np.concatenate([self._rest, new], axis=1)
        whole = rows.shape[1] // self.size * self.size
        self._rest = rows[:, whole:]
        if whole:
            self._add(rows[:, :whole].reshape(4, -1, self.size), temperature)

    def since(self, number: int) -> tuple[int, Array]:
        """The bins from ``number`` on that are still known, in units of the page, and the number of the next one."""
        with self._lock:
            first = max(number, self.count - len(self._ring), 0)
            places = np.arange(first, self.count) % len(self._ring)
            return self.count, self._ring[places] * _FACTOR

    def _begin(self, now: float) -> None:
        """A new run: what was held back is let go, and a gap stands before it."""
        if self.count or len(self._held):
            gap = np.full((1, len(COLUMNS)), np.nan)
            gap[0, 0] = max(now, self.time)
            self._store(np.concatenate([self._held, gap]))
        self.time = max(now, self.time)
        self._rest, self._held, self._means = np.empty((4, 0)), np.empty((0, len(COLUMNS))), np.empty(0)

    def _add(self, bins: Array, temperature: float) -> None:
        """``bins`` is (4, bins, samples); the last bin is held back until the one after it gives its velocity."""
        time, x, force, voltage = bins
        low, high = force.argmin(axis=1), force.argmax(axis=1)
        row = np.arange(len(low))
        first, second = np.minimum(low, high), np.maximum(low, high)
        rows = np.column_stack([
            time[:, 0], x.min(axis=1), x.max(axis=1), force[row, low], force[row, high],
            voltage.min(axis=1), voltage.max(axis=1), np.full(len(low), temperature), np.zeros(len(low)),
            x[row, first], force[row, first], x[row, second], force[row, second],
        ])  # fmt: skip
        held, means = np.concatenate([self._held, rows]), np.concatenate([self._means, x.mean(axis=1)])
        if len(means) > 1:
            velocity = np.gradient(means, self.width)
            held[:, 8] = velocity[-len(held) :]
        self._store(held[:-1])
        self._held, self._means = held[-1:], means[-2:]

    def _store(self, rows: Array) -> None:
        with self._lock:
            places = np.arange(self.count, self.count + len(rows)) % len(self._ring)
            self._ring[places] = rows
            self.count += len(rows)


def as_lists(rows: Array) -> dict[str, list[float | None]]:
    """Bins by their names, rounded to what a page shows; None stands for nan, which JSON has not."""
    columns: dict[str, list[float | None]] = {}
    for (name, (_, _, digits)), column in zip(COLUMNS.items(), rows.T, strict=True):
        values = np.round(column, digits)
        columns[name] = (
            values.tolist() if np.isfinite(values).all() else [v if v == v else None for v in values.tolist()]
        )
    return columns
