r"""Random displacement: many frequencies at once, by seed; what predicts most of other motions, and for validation.

.. math:: x = g \sum_k \frac{a}{f_k} \sin(2 \pi f_k t + \varphi_k), \qquad f_k = k/T \text{ from } low \text{ to } high

with phases drawn by the seed, the same speed at every frequency, and a raised cosine g over ``taper`` seconds at both ends. It
is scaled so that its farthest position is ``amplitude``; the peak speed has no closed form and is taken from the path.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, floor, pi
from typing import Annotated, ClassVar

import numpy as np

from dampyr.campaigns.paths import Array, PathPiece, around, driven, raised
from dampyr.campaigns.step import (
    Frequency,
    Length,
    Peaks,
    Period,
    Rest,
    Time,
    Volts,
    check_ranges,
    enough_points,
)
from dampyr.errors import InputError
from dampyr.rig import Drive, RigSettings

FINE = 0.001  # s, the grid on which the path is made


@dataclass(frozen=True)
class Random:
    """A random displacement of a band of frequencies."""

    amplitude: Annotated[float, Length, "farthest position from the middle"]
    low: Annotated[float, Frequency, "lowest frequency of the band"] = 0.1
    high: Annotated[float, Frequency, "highest frequency of the band"] = 2.0
    duration: Annotated[float, Time, "duration of the motion"] = 30.0
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    seed: Annotated[int, "seed of the phases"] = 0
    taper: Annotated[float, Time, "time in which the motion grows, and fades"] = 2.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "voltage")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "low", "high", "voltage", "seed")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.seed < 0:
            raise InputError(f"seed = {self.seed} is not allowed; it must be at least 0")
        enough_points(self.period, self.high)
        if floor(self.high * self.duration + 1e-9) <= ceil(self.low * self.duration - 1e-9):
            raise InputError(
                f"low = {self.low:g} to high = {self.high:g} Hz holds fewer than two frequencies in {self.duration:g} s; "
                "widen the band or lengthen the test"
            )
        if 2 * self.taper > self.duration:
            raise InputError(f"taper = {self.taper:g} s at both ends is more than duration = {self.duration:g} s")

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        t, x, _ = self._path()
        piece = PathPiece(float(t[-1]), lambda at: np.interp(at, t, x))
        return driven(around([piece], 0.0, self.rest_before), self.period, self.voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """The amplitude, and the greatest speed on a grid of 1 ms."""
        return Peaks(self.amplitude, float(np.abs(self._path()[2]).max()))

    def _path(self) -> tuple[Array, Array, Array]:
        t, x, v = unit_path(self.low, self.high, self.duration, self.seed, self.taper)
        return t, self.amplitude * x, self.amplitude * v


@lru_cache(maxsize=32)
def unit_path(low: float, high: float, duration: float, seed: int, taper: float) -> tuple[Array, Array, Array]:
    """Times [s], positions and speeds of the path whose farthest position is 1 m."""
    n = max(round(duration / FINE), 4)
    f = np.fft.rfftfreq(n, FINE)
    band = (f > low * (1 - 1e-9)) & (f < high * (1 + 1e-9)) & (f > 0)
    phases = np.random.default_rng(seed).uniform(0.0, 2 * pi, int(band.sum()))
    lines = np.zeros(f.size, dtype=complex)
    lines[band] = np.exp(1j * phases) / f[band]
    t = np.arange(n + 1, dtype=np.float64) * FINE
    s, v = (np.append(y, y[0]) for y in (np.fft.irfft(lines, n), np.fft.irfft(2j * pi * f * lines, n)))
    window = raised(t / taper) * raised((t[-1] - t) / taper)
    x = window * s
    return t, x / np.abs(x).max(), (window * v + np.gradient(window, FINE) * s) / np.abs(x).max()
