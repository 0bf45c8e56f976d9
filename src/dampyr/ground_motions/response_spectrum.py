r"""Response spectra: the peaks of linear oscillators on a shaking ground.

.. math:: \ddot u + 2\zeta\omega\dot u + \omega^2 u = -a_g(t), \qquad S_d = \max_t |u|, \quad
          S_{pv} = \omega S_d, \quad S_a = \omega^2 S_d

Exact for a ground acceleration that is linear between its samples ([NigamJennings1969]_, see `oscillator`), with the peaks
inside the steps. Published spectra often hold the largest *sample* instead; ``sampled=True`` does so for comparison.

References
----------
.. [Chopra2017] A. K. Chopra, Dynamics of Structures, 5th ed., Pearson, 2017, chapter 6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import oscillator
from dampyr.ground_motions.motion import GroundMotion

Array = NDArray[np.float64]

MAX_PARTS = 20_000
STANDARD_PERIODS = tuple(float(f"{T:.4g}") for T in np.geomspace(0.02, 10.0, 136))
"""Periods [s] for a figure: 0.02 s to 10 s, 50 in each decade."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Peaks of oscillators, each array (m dampings, p periods); a scalar damping or period leaves its axis out.

    At period 0, the rigid oscillator, displacement is 0 and both accelerations are the PGA.
    """

    periods: Array  # (p,) s
    damping: Array  # (m,) ratio to critical
    displacement: Array  # Sd, m, relative to the ground
    velocity: Array  # m/s, relative to the ground: the true one
    acceleration: Array  # m/s2, absolute: the true one
    pseudo_velocity: Array  # omega Sd, m/s
    pseudo_acceleration: Array  # Sa = omega^2 Sd, m/s2
    sampled: bool  # True: the largest samples; False: the peaks of the motion itself
    motion: str = ""  # the name of the ground motion

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` with dims damping and period; units in ``attrs``."""
        import xarray

        shape = (self.damping.size, self.periods.size)
        units = {
            "displacement": "m",
            "velocity": "m/s",
            "acceleration": "m/s^2",
            "pseudo_velocity": "m/s",
            "pseudo_acceleration": "m/s^2",
        }
        dims = ("damping", "period")
        data = {k: (dims, np.reshape(getattr(self, k), shape), {"units": unit}) for k, unit in units.items()}
        coordinates = {
            "damping": np.atleast_1d(self.damping),
            "period": ("period", np.atleast_1d(self.periods), {"units": "s"}),
        }
        return xarray.Dataset(data, coordinates, {"motion": self.motion, "sampled": int(self.sampled)})


def spectrum(
    motion: GroundMotion,
    periods: ArrayLike = STANDARD_PERIODS,
    damping: ArrayLike = 0.05,
    sampled: bool = False,
) -> Spectrum:
    """The response spectrum of a ground motion.

    Parameters
    ----------
    periods : undamped natural periods [s], a number or (p,); 0 is the rigid oscillator.
    damping : ratios to critical, a number or (m,), 0 to 10; 1 and more are overdamped.
    sampled : take the largest sample instead of the peak inside the step.

    The motion ends with its last sample: what an oscillator does afterwards is not looked at. Where that matters (long periods,
    short pulses, low damping) add a rest first, ``padded(motion, seconds)``. Raises :class:`~dampyr.errors.InputError` for
    periods and dampings that make no sense.
    """
    T, zeta = np.array(periods, dtype=float), np.array(damping, dtype=float)
    _check(T, zeta, motion.dt)
    shape = zeta.shape + T.shape
    omega = np.zeros_like(T)
    np.divide(2 * np.pi, T, out=omega, where=T > 0)
    peaks = _peaks(motion, np.array(omega, ndmin=1), np.array(zeta, ndmin=1), sampled)
    peaks[:, :, np.atleast_1d(T) == 0] = np.array([0.0, 0.0, motion.pga])[:, None, None]
    d, v, a = (each.reshape(shape) for each in peaks)
    pseudo = np.where(T > 0, omega**2 * d, motion.pga)
    return Spectrum(T, zeta, d, v, a, omega * d, pseudo, sampled, motion.name)


def _peaks(motion: GroundMotion, omega: Array, zeta: Array, sampled: bool) -> Array:
    from dampyr.models.codegen.kernels import compile_cached

    peaks = np.zeros((3, len(zeta), len(omega)))
    compile_cached(oscillator.march)(np.array(motion.acceleration), motion.dt, omega, zeta, bool(sampled), peaks)
    return peaks


def _check(T: Array, zeta: Array, dt: float) -> None:
    for name, values, unit in (("periods", T, " s"), ("damping", zeta, "")):
        if values.ndim > 1 or values.size == 0:
            raise InputError(f"{name} has shape {values.shape}; give a number or one row of at least 1 number")
        bad = values[~(np.isfinite(values) & (values >= 0))]
        if bad.size:
            raise InputError(f"{name}: {bad.flat[0]:g}{unit} is not allowed; it must be finite and at least 0")
    if zeta.max() > 10:
        raise InputError(f"damping: {zeta.max():g} is not allowed; it is a ratio to critical, 0.05 for 5 %, at most 10")
    shortest = T[T > 0].min(initial=np.inf)
    least = 2 * np.pi * (1 + 2 * zeta.max()) * dt / (oscillator.REACH * MAX_PARTS)
    if shortest < least:
        raise InputError(
            f"periods: {shortest:g} s is too short for samples every {dt:g} s; it must be 0 (rigid) or at least {least:.2g} s"
        )
