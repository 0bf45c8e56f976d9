r"""Sweep: one amplitude while the frequency runs from ``start`` to ``stop``; for how a damper depends on frequency.

.. math:: x = A \sin \varphi, \qquad \dot\varphi = 2 \pi f_0 (f_1/f_0)^{t/T}

Every octave takes the same time. One cycle at each end grows and fades as a raised cosine, one more of constant frequency
stands inside of each; the sweep's duration is rounded so that it has whole cycles. Its peak speed is that of the highest
frequency. Where the table is limited in speed, sines of different amplitudes reach further. With ``fit_limits`` the plan lowers
the amplitude to the largest that the rig can do, and says so; without, a sweep that the rig cannot do is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import log, pi
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

SWEPT = 2  # cycles that the sweep has at least


@dataclass(frozen=True)
class Sweep:
    """A sine whose frequency changes, as many octaves in every second."""

    amplitude: Annotated[float, Length, "amplitude of the motion, half of the peak to peak"]
    start: Annotated[float, Frequency, "frequency at the begin"]
    stop: Annotated[float, Frequency, "frequency at the end"]
    duration: Annotated[float, Time, "duration of the sweep between them"] = 60.0
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01
    fit_limits: Annotated[bool, "lower the amplitude to what the rig can do"] = field(default=False, repr=False)

    lowers: ClassVar[tuple[str, ...]] = ("amplitude", "stop", "start", "voltage")
    named: ClassVar[tuple[str, ...]] = ("amplitude", "start", "stop", "voltage")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = True
    fits: ClassVar[str] = "amplitude"

    def __post_init__(self) -> None:
        check_ranges(self)
        enough_points(self.period, max(self.start, self.stop))
        if self.start == self.stop:
            raise InputError(f"start = stop = {self.start:g} Hz sweeps nothing; use the kind sine")
        if round(self._mean * self.duration) < SWEPT:
            least = SWEPT / self._mean
            raise InputError(f"duration = {self.duration:g} s is less than {SWEPT} cycles; give at least {least:.3g} s")

    @property
    def _mean(self) -> float:
        return (self.stop - self.start) / log(self.stop / self.start)

    @property
    def swept(self) -> float:
        """The sweep's duration [s], rounded to whole cycles."""
        return round(self._mean * self.duration) / self._mean

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        length = self.swept + 2 / self.start + 2 / self.stop
        return driven(around([PathPiece(length, self._at)], 0.0, self.rest_before), self.period, self.voltage)

    def _at(self, t: Array) -> Array:
        f0, f1, T = self.start, self.stop, self.swept
        inside = np.clip(t - 2 / f0, 0.0, T)
        swept = self._mean * T * np.expm1(log(f1 / f0) * inside / T) / (f1 / f0 - 1)
        cycles = f0 * np.minimum(t, 2 / f0) + swept + f1 * np.maximum(t - 2 / f0 - T, 0.0)
        grown = raised(t * f0) * raised((T + 2 / f0 + 2 / f1 - t) * f1)
        return np.asarray(self.amplitude * grown * np.sin(2 * pi * cycles), dtype=float)

    def peaks(self, rig: RigSettings) -> Peaks:
        """A and 2 pi A times the highest frequency."""
        return Peaks(self.amplitude, 2 * pi * max(self.start, self.stop) * self.amplitude)
