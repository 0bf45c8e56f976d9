r"""Intensity measures: how strong a ground motion is, in single numbers, exact for acceleration linear between samples.

.. math:: I_A = \frac{\pi}{2g}\int a^2\,dt, \qquad CAV = \int |a|\,dt

References
----------
.. [Arias1970] A. Arias, "A measure of earthquake intensity", in R. J. Hansen (ed.), Seismic Design for Nuclear Power Plants,
   MIT Press, 438-483, 1970.
.. [TrifunacBrady1975] M. D. Trifunac and A. G. Brady, "A study on the duration of strong earthquake ground motion", Bulletin of
   the Seismological Society of America 65(3), 581-626, 1975.
.. [EPRI1988] Electric Power Research Institute, A criterion for determining exceedance of the operating basis earthquake,
   report NP-5930, 1988 (the cumulative absolute velocity).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import integrals
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.response_spectrum import spectrum
from dampyr.shown import Shown
from dampyr.units import STANDARD_GRAVITY

Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Measures(Shown):
    """The intensity measures of one ground motion, SI."""

    pga: float  # peak ground acceleration, m/s2
    pgv: float  # peak ground velocity, m/s
    pgd: float  # peak ground displacement, m
    arias: float  # Arias intensity, m/s
    duration_5_95: float  # significant duration, s: from 5 % to 95 % of the Arias intensity
    duration_5_75: float  # s
    cumulative_absolute_velocity: float  # m/s


def measures(motion: GroundMotion) -> Measures:
    """All measures that need no oscillator; for Sa see `sa`. A motion of zeros has significant durations of 0.

    Examples
    --------
    >>> import dampyr as dp
    >>> measures = dp.ground_motions.measures(dp.ground_motions.el_centro())
    >>> round(measures.pga, 3), round(measures.duration_5_95, 1)
    (3.127, 23.9)
    """
    still = motion.pga == 0
    return Measures(
        motion.pga,
        pgv(motion),
        pgd(motion),
        arias(motion),
        0.0 if still else significant_duration(motion, 0.05, 0.95),
        0.0 if still else significant_duration(motion, 0.05, 0.75),
        cumulative_absolute_velocity(motion),
    )


def pgv(motion: GroundMotion) -> float:
    """Peak ground velocity [m/s], between samples too, from rest and without any correction."""
    return integrals.peak_velocity(np.asarray(motion.acceleration), motion.dt)


def pgd(motion: GroundMotion) -> float:
    """Peak ground displacement [m], between samples too. Of a raw record it may be mostly drift: see `corrected`."""
    return integrals.peak_displacement(np.asarray(motion.acceleration), motion.dt)


def sa(motion: GroundMotion, period: float, damping: float = 0.05) -> float:
    """Pseudo-acceleration [m/s2] of an oscillator of ``period`` [s] and ``damping`` (ratio), its peak inside the step."""
    return float(spectrum(motion, period, damping).pseudo_acceleration)


def husid(motion: GroundMotion) -> Array:
    """The Arias intensity up to each sample (n,) [m/s]."""
    a = np.asarray(motion.acceleration)
    steps = motion.dt / 3 * (a[:-1] ** 2 + a[:-1] * a[1:] + a[1:] ** 2)
    return math.pi / (2 * STANDARD_GRAVITY) * np.concatenate(([0.0], np.cumsum(steps)))


def arias(motion: GroundMotion) -> float:
    """Arias intensity [m/s] ([Arias1970]_), g = 9.80665 m/s2."""
    return float(husid(motion)[-1])


def significant_duration(motion: GroundMotion, low: float = 0.05, high: float = 0.95) -> float:
    """Seconds from where the Arias intensity has reached the share ``low`` to where it has reached ``high``.

    The significant duration of [TrifunacBrady1975]_ with 0.05 and 0.95. The instants are found inside the steps, where the
    intensity is a cubic.
    """
    if not 0 <= low < high <= 1:
        raise InputError(
            f"shares {low:g} to {high:g} are not allowed; they must be 0 <= low < high <= 1, such as 0.05 to 0.95"
        )
    return reached(motion, high) - reached(motion, low)


def reached(motion: GroundMotion, share: float) -> float:
    """When [s] the Arias intensity has reached this share of its end; the first such instant."""
    curve = husid(motion)
    if curve[-1] == 0:
        raise InputError(f"{motion.name}: all samples are 0, so that it has no significant duration")
    k = max(int(np.searchsorted(curve, share * curve[-1])) - 1, 0)
    a0, a1 = motion.acceleration[k], motion.acceleration[k + 1]
    wanted = (share * curve[-1] - curve[k]) * 2 * STANDARD_GRAVITY / math.pi / motion.dt
    low, high = 0.0, 1.0
    for _ in range(52):  # halvings, to the last bit of a part of a step
        x = 0.5 * (low + high)
        so_far = a0**2 * x + a0 * (a1 - a0) * x**2 + (a1 - a0) ** 2 * x**3 / 3
        low, high = (x, high) if so_far < wanted else (low, x)
    return (k + high) * motion.dt if share > 0 else 0.0


def cumulative_absolute_velocity(motion: GroundMotion) -> float:
    """The integral of \\|a\\| [m/s] ([EPRI1988]_), over all of the motion: without the threshold of its standardised form."""
    before, after = np.abs(motion.acceleration[:-1]), np.abs(motion.acceleration[1:])
    whole = before + after
    crosses = np.asarray(motion.acceleration[:-1]) * np.asarray(motion.acceleration[1:]) < 0
    split = np.divide(before**2 + after**2, whole, out=np.zeros_like(whole), where=whole > 0)
    return float(0.5 * motion.dt * np.sum(np.where(crosses, split, whole)))
