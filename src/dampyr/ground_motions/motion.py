"""A ground motion: how the ground accelerates, sample by sample."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.atomic_write import whole_file
from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import integrals
from dampyr.ground_motions.oscillator import oscillator_peaks
from dampyr.shown import Shown
from dampyr.units import STANDARD_GRAVITY, in_si

Array = NDArray[np.float64]
STRONGEST = 5.0  # g: 4.4 g were recorded near Iwate-Miyagi in 2008, the largest so far


@dataclass(frozen=True, eq=False, repr=False)
class GroundMotion(Shown):
    """Ground acceleration (n,) [m/s2] every ``dt`` seconds from t = 0, linear between samples.

    Checked when made: at least two finite samples, dt > 0; an :class:`~dampyr.errors.InputError` says what
    is wrong; above 5 g a warning asks about the unit. Quantities and labelled arrays are converted from their units.

    ``source`` says where the numbers are from, ``history`` what was done to them since, in order. The
    array is a copy and read-only.
    """

    acceleration: Array
    dt: float
    name: str = "ground motion"
    source: str = ""
    history: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        values = np.array(in_si(self.acceleration, "m/s^2", f"{self.name}: acceleration"), dtype=float)
        object.__setattr__(self, "dt", in_si(self.dt, "s", f"{self.name}: dt"))
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
        peak = float(np.abs(values).max())
        if peak > STRONGEST * STANDARD_GRAVITY and not self.history:  # what was scaled was asked for
            warnings.warn(
                f"{self.name}: peaks at {peak:.4g} m/s2, {peak / STANDARD_GRAVITY:.3g} g; no earthquake is known above "
                f"{STRONGEST:g} g, so check the unit of the acceleration (gal = cm/s2, g, mg)",
                DampyrWarning,
                stacklevel=3,
            )
        values.flags.writeable = False
        object.__setattr__(self, "acceleration", values)
        object.__setattr__(self, "dt", float(self.dt))
        object.__setattr__(self, "history", tuple(self.history))

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

    @property
    def velocity(self) -> Array:
        """Ground velocity (n,) [m/s] from rest: the exact integral of the acceleration."""
        return integrals.velocity(self.acceleration, self.dt)

    @property
    def displacement(self) -> Array:
        """Ground displacement (n,) [m] from 0: the exact integral of the velocity. A raw record drifts; see ``corrected``."""
        return integrals.displacement(self.acceleration, self.dt)

    def changed(self, acceleration: ArrayLike, note: str, dt: float | None = None) -> GroundMotion:
        """A new motion with these samples and ``note``, what was done, added to its history."""
        values = np.asarray(acceleration, dtype=float)
        return replace(self, acceleration=values, dt=self.dt if dt is None else dt, history=(*self.history, note))

    def save(self, path: str | Path) -> Path:
        """Write time and acceleration as a text file of two columns, which `read` takes; name and history stand above them.

        Raises :class:`~dampyr.errors.FileError` where the file cannot be written.
        """
        path = Path(path)
        above = [f"# {line}" for line in (self.name, self.source, *self.history) if line]
        rows = (f"{t:.12g},{a:.17g}" for t, a in zip(self.time, self.acceleration, strict=True))
        text = "\n".join([*above, "time [s],acceleration [m/s^2]", *rows, ""])
        with whole_file(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
        return path

    def scaled(self, factor: float) -> GroundMotion:
        """The same motion, ``factor`` times as strong; a negative factor turns it round."""
        factor = float(in_si(factor, "dimensionless", "the scale"))
        if not np.isfinite(factor):
            raise InputError(f"the scale {factor!r} is not a finite number")
        values = np.asarray(self.acceleration) * factor
        name = f"{self.name} x {factor:g}"
        return replace(self, acceleration=values, name=name, history=(*self.history, f"scaled by {factor:.12g}"))

    def scaled_to_pga(self, value: float) -> GroundMotion:
        """The same motion with a peak ground acceleration of ``value`` [m/s2]."""
        value = in_si(value, "m/s^2", "the PGA")
        return self.scaled(_factor(value, self.pga, f"{self.name}: a PGA of"))

    def scaled_to_sa(self, value: float, period: float, damping: float = 0.05) -> GroundMotion:
        """The same motion with a pseudo-acceleration of ``value`` [m/s2] at ``period`` [s] and ``damping`` (ratio)."""
        value, period = in_si(value, "m/s^2", "the spectral acceleration"), in_si(period, "s", "the period")
        period_, damping_ = np.array(period, dtype=float), np.array(damping, dtype=float)
        current = float(oscillator_peaks(self.acceleration, self.dt, period_, damping_)[-1])
        return self.scaled(_factor(value, current, f"{self.name}: Sa({period:g} s) of"))


def _factor(value: float, current: float, target: str) -> float:
    if not np.isfinite(value) or value <= 0:
        raise InputError(f"{target} {value:g} m/s^2 is not allowed; it must be greater than 0")
    if current <= 0:
        raise InputError(
            f"{target} {value:g} m/s^2 cannot be reached by scaling: the motion is 0 there; take another one"
        )
    return value / current
