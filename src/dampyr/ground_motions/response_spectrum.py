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

from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.oscillator import oscillator_peaks
from dampyr.shown import Shown

Array = NDArray[np.float64]

STANDARD_PERIODS = tuple(float(f"{T:.4g}") for T in np.geomspace(0.02, 10.0, 136))
"""Periods [s] for a figure: 0.02 s to 10 s, 50 in each decade."""


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(Shown):
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
        dims = ("damping", "period")
        data = {k: (dims, np.reshape(getattr(self, k), shape), {"units": unit}) for k, unit in UNITS.items()}
        coordinates = {
            "damping": np.atleast_1d(self.damping),
            "period": ("period", np.atleast_1d(self.periods), {"units": "s"}),
        }
        return xarray.Dataset(data, coordinates, {"motion": self.motion, "sampled": int(self.sampled)})


UNITS = {
    "displacement": "m",
    "velocity": "m/s",
    "acceleration": "m/s^2",
    "pseudo_velocity": "m/s",
    "pseudo_acceleration": "m/s^2",
}


def spectrum(
    motion: GroundMotion,
    periods: ArrayLike = STANDARD_PERIODS,
    damping: ArrayLike = 0.05,
    sampled: bool = False,
) -> Spectrum:
    """The response spectrum of a ground motion.

    Parameters
    ----------
    motion
        The motion of the ground. It ends with its last sample: what an oscillator does afterwards is left out. Where that
        matters (long periods, short pulses, low damping) add a pause first, ``padded(motion, seconds)``.
    periods
        Undamped natural periods in s, a number or ``(p,)``; 0 is the rigid oscillator.
    damping
        Ratios to critical, a number or ``(m,)``, 0 to 10 (0.05 is 5 %, the default); 1 and more are overdamped.
    sampled
        Take the largest sample instead of the peak inside the step.

    Raises
    ------
    InputError
        A period or a damping makes no sense.

    Examples
    --------
    >>> import dampyr as dp
    >>> spectrum = dp.ground_motions.spectrum(dp.ground_motions.el_centro(), periods=[0.0, 0.5, 1.0])
    >>> spectrum.pseudo_acceleration.round(2)
    array([3.13, 9.01, 4.46])
    """
    T, zeta = np.array(periods, dtype=float), np.array(damping, dtype=float)
    d, v, a, pseudo_v, pseudo_a = oscillator_peaks(motion.acceleration, motion.dt, T, zeta, sampled)
    return Spectrum(T, zeta, d, v, a, pseudo_v, pseudo_a, sampled, motion.name)
