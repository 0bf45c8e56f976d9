r"""Spectra of two horizontal components that do not depend on how the instrument was turned: RotD50 and RotD100.

.. math:: a_\theta = a_1 \cos\theta + a_2 \sin\theta, \qquad
          \mathrm{RotD}nn(T) = n\text{-th percentile over } \theta \text{ of } S_a(T; a_\theta)

RotD50 is the median and RotD100 the largest over all angles, period by period [Boore2010]_; here in steps of one degree from 0
to 179, after which they repeat with the other sign. Peaks are those inside the steps, as of `spectrum`.

References
----------
.. [Boore2010] D. M. Boore, "Orientation-independent, nongeometric-mean measures of seismic intensity from two horizontal
   components of motion", Bulletin of the Seismological Society of America 100(4), 1830-1835, 2010.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.oscillator import rotated_displacements
from dampyr.ground_motions.response_spectrum import STANDARD_PERIODS
from dampyr.shown import Shown

Array = NDArray[np.float64]
DEGREES = np.arange(180.0)
SAME_STEP = 1e-9  # relative: steps that differ by less are equal but for the digits of a file


@dataclass(frozen=True, eq=False, repr=False)
class RotatedSpectrum(Shown):
    """Pseudo-accelerations over all angles in the plane of two components; at period 0 peak accelerations of the ground."""

    periods: Array  # (p,) s
    damping: float  # ratio to critical
    rotd00: Array  # (p,) m/s2, the least
    rotd50: Array  # (p,) m/s2, the median
    rotd100: Array  # (p,) m/s2, the largest
    angle: Array  # (p,) degrees from the first component to the second, of the largest
    motions: tuple[str, str]  # names of the two components


def rotated_spectrum(
    first: GroundMotion, second: GroundMotion, periods: ArrayLike = STANDARD_PERIODS, damping: float = 0.05
) -> RotatedSpectrum:
    """RotD50 and RotD100 of two horizontal components at right angles.

    Parameters
    ----------
    first, second
        The components, of one step and one length: an instrument records both together.
    periods
        Undamped natural periods in s, a number or ``(p,)``; 0 is the ground itself.
    damping
        Ratio to critical.

    Raises
    ------
    InputError
        The components differ in step or length, or a period or the damping makes no sense.

    Examples
    --------
    >>> import dampyr as dp
    >>> motion = dp.ground_motions.el_centro()
    >>> same = dp.ground_motions.rotated_spectrum(motion, motion, periods=[0.0, 0.5])
    >>> (same.rotd100 / dp.ground_motions.spectrum(motion, [0.0, 0.5]).pseudo_acceleration).round(6)  # the square root of 2
    array([1.414214, 1.414214])
    """
    if first.n != second.n or abs(first.dt - second.dt) > SAME_STEP * first.dt:
        raise InputError(
            f"{first.name} has {first.n} samples every {first.dt:g} s and {second.name} {second.n} every {second.dt:g} s; give "
            "two components of one recording"
        )
    T, angles = np.atleast_1d(np.array(periods, dtype=float)), np.deg2rad(DEGREES)
    a1, a2 = np.asarray(first.acceleration), np.asarray(second.acceleration)
    with np.errstate(divide="ignore"):
        squared = np.where(T > 0, (2 * np.pi / T) ** 2, 0.0)
    peaks = squared * rotated_displacements(a1, a2, first.dt, T, float(damping), angles)
    ground = np.array([np.abs(np.cos(angle) * a1 + np.sin(angle) * a2).max() for angle in angles])
    peaks[:, T == 0] = ground[:, None]
    return RotatedSpectrum(
        T, float(damping), peaks.min(axis=0), np.median(peaks, axis=0), peaks.max(axis=0),
        DEGREES[peaks.argmax(axis=0)], (first.name, second.name),
    )  # fmt: skip
