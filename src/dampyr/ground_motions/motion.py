"""A ground motion: how the ground accelerates, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GroundMotion:
    """Ground acceleration (n,) [m/s2] every ``dt`` seconds from t = 0, linear between samples.

    Checked when made: at least two finite samples, dt > 0; an :class:`~dampyr.errors.InputError` says what
    is wrong. ``source`` says where the numbers are from. The array is a copy and read-only.
    """

    acceleration: Array
    dt: float
    name: str = "ground motion"
    source: str = ""

    def __post_init__(self) -> None:
        values = np.array(self.acceleration, dtype=float)
        if values.ndim != 1 or len(values) < 2:
            raise InputError(
                f"{self.name}: acceleration has shape {values.shape}; it must be one row of at least 2 samples"
            )
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise InputError(
                f"{self.name}: {len(bad)} of {len(values)} samples are not "
                f"finite, the first is number {bad[0] + 1}; "
                "repair or cut the record"
            )
        if not np.isfinite(self.dt) or self.dt <= 0:
            raise InputError(f"{self.name}: dt = {self.dt!r} s is not allowed; it must be greater than 0")
        values.flags.writeable = False
        object.__setattr__(self, "acceleration", values)
        object.__setattr__(self, "dt", float(self.dt))

    @property
    def n(self) -> int:
        """The number of samples."""
        return len(self.acceleration)

    @property
    def time(self) -> Array:
        """Sample times (n,) [s], the first is 0."""
        return np.arange(self.n, dtype=np.float64) * self.dt

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return (self.n - 1) * self.dt

    @property
    def pga(self) -> float:
        """Peak ground acceleration [m/s2], its size."""
        return float(np.max(np.abs(self.acceleration)))

    def scaled(self, factor: float) -> GroundMotion:
        """The same motion, ``factor`` times as strong; a negative factor turns it round."""
        if not np.isfinite(factor):
            raise InputError(f"the scale {factor!r} is not a finite number")
        values = np.asarray(self.acceleration) * factor
        return replace(self, acceleration=values, name=f"{self.name} x {factor:g}")
