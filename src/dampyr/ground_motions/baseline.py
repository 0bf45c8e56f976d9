r"""Baseline correction: a polynomial taken off the acceleration, so that velocity and displacement do not drift.

The polynomial is the one that makes the mean square of the velocity least ([BergHousner1961]_ with a parabola), here of any
degree up to 6, and so that the ground is at rest where it began when the record ends:

.. math:: \min_c \int \Big(v - \sum_j c_j V_j\Big)^2 dt \quad \text{with} \quad v(T) = 0,\; d(T) = 0,

V_j being the velocity of the acceleration t^j. A permanent displacement of the ground (fling, next to a fault) is taken off
with the drift: for such records use a correction that knows it.

References
----------
.. [BergHousner1961] G. V. Berg and G. W. Housner, "Integrated velocity and displacement of strong earthquake ground motion",
   Bulletin of the Seismological Society of America 51(2), 175-189, 1961.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import integrals
from dampyr.ground_motions.motion import GroundMotion

Array = NDArray[np.float64]


def corrected(motion: GroundMotion, degree: int = 2, at_rest: bool = True) -> GroundMotion:
    """The motion less a polynomial of ``degree`` (0 to 6) in time, see above.

    ``at_rest``: velocity and displacement end at 0, which needs a degree of at least 1; without it only the mean square of the
    velocity is made small, as [BergHousner1961]_ do. The history tells how much was taken off.
    """
    least = 1 if at_rest else 0
    if int(degree) != degree or not least <= degree <= 6:
        raise InputError(f"degree = {degree!r} is not allowed; it must be a whole number from {least} to 6")
    if motion.n < 2 * degree + 4:
        raise InputError(
            f"{motion.name}: {motion.n} samples are too few for a baseline of degree {degree}; lower the degree"
        )
    basis: Array = legendre.legvander(np.linspace(-1.0, 1.0, motion.n), int(degree)).astype(np.float64)
    baseline = basis @ _coefficients(np.asarray(motion.acceleration), basis, motion.dt, at_rest)
    rest = ", the ends at rest" if at_rest else ""
    note = (
        f"baseline of degree {degree} taken off (least mean square velocity{rest}), "
        f"at most {np.abs(baseline).max():.3g} m/s^2"
    )
    return motion.changed(motion.acceleration - baseline, note)


def _coefficients(a: Array, basis: Array, h: float, at_rest: bool) -> Array:
    """Least squares on the velocity; with ``at_rest`` only among those that meet both ends."""
    V = np.column_stack([integrals.velocity(column, h) for column in basis.T])
    v = integrals.velocity(a, h)
    if not at_rest:
        return np.asarray(np.linalg.lstsq(V, v, rcond=None)[0], dtype=np.float64)
    D = [integrals.displacement(column, h)[-1] for column in basis.T]
    ends = np.array([V[-1], D])
    wanted = np.array([v[-1], integrals.displacement(a, h)[-1]])
    particular = np.linalg.lstsq(ends, wanted, rcond=None)[0]
    free = np.linalg.svd(ends)[2][2:].T  # the directions that leave both ends as they are
    rest = np.linalg.lstsq(V @ free, v - V @ particular, rcond=None)[0]
    return np.asarray(particular + free @ rest, dtype=np.float64)
