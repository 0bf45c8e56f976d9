r"""The quarter car: a wheel on its tyre, a quarter of the body on its suspension, and the road as the ground.

.. math:: m_u \ddot x_u = k_s (x_s - x_u) + c_s (\dot x_s - \dot x_u) + f - k_t (x_u - y) - c_t (\dot x_u - \dot y),
          \qquad m_s \ddot x_s = -k_s (x_s - x_u) - c_s (\dot x_s - \dot x_u) - f

Every force depends on differences of x_s, x_u and the road's height y alone, the tyre's dashpot too. In
q = x - y the equations are therefore those of a building whose ground moves by y: nothing is neglected, and
only the second derivative of the road is needed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.structures.building import Building
from dampyr.units import in_si


def quarter_car(
    sprung: float,
    unsprung: float,
    suspension: float,
    tyre: float,
    damping: float = 0.0,
    tyre_damping: float = 0.0,
    name: str = "quarter car",
) -> Building:
    """A quarter of a car: floor "unsprung" (the wheel) on the road, floor "sprung" (the body) above it.

    Parameters
    ----------
    sprung, unsprung
        The masses of the body and of the wheel, kg, greater than 0.
    suspension, tyre
        Their stiffnesses, N/m, greater than 0.
    damping
        Of the suspension without the damper that is to be studied, N s/m; by default none.
    tyre_damping
        Of the tyre, N s/m; by default none.
    name
        What the car is called.

    The damper stands between wheel and body, ``dampers={2: damper}`` or ``{("unsprung", "sprung"): damper}``.
    ``peak_drift`` is then (tyre deflection, suspension travel), ``acceleration[1]`` the body's, ``base_shear``
    the change of the tyre's force on the road. The tyre is linear and never leaves the road: compare that change
    with the weight (sprung + unsprung) g.

    There are no defaults, cars differ. The Golden Car of the International Roughness Index has, per kg of
    sprung mass, unsprung 0.15, suspension 63.3 1/s2, tyre 653 1/s2 and damping 6.0 1/s (Sayers, Gillespie and
    Queiroz 1986, World Bank Technical Paper 45; ASTM E1926).

    Raises
    ------
    InputError
        A mass or a stiffness is not greater than 0, or a dashpot is negative.

    Examples
    --------
    >>> import dampyr as dp
    >>> car = dp.structures.quarter_car(400.0, 60.0, suspension=25e3, tyre=260e3)
    >>> car.floors, car.frequencies.round(2)
    (('unsprung', 'sprung'), array([ 1.2 , 10.98]))
    """
    sprung, unsprung = in_si(sprung, "kg", "sprung"), in_si(unsprung, "kg", "unsprung")
    suspension, tyre = in_si(suspension, "N/m", "suspension"), in_si(tyre, "N/m", "tyre")
    damping, tyre_damping = in_si(damping, "N s/m", "damping"), in_si(tyre_damping, "N s/m", "tyre_damping")
    positive = {"sprung": sprung, "unsprung": unsprung, "suspension": suspension, "tyre": tyre}
    for key, value in (positive | {"damping": damping, "tyre_damping": tyre_damping}).items():
        low = "greater than 0" if key in positive else "at least 0"
        if not np.isfinite(value) or value < 0 or (key in positive and value == 0):
            raise InputError(f"{key} = {value!r} is not allowed; it must be finite and {low}")
    return Building(
        M=np.diag([unsprung, sprung]),
        C=_chain(tyre_damping, damping),
        K=_chain(tyre, suspension),
        name=name,
        floors=("unsprung", "sprung"),
    )


def road(height: ArrayLike, spacing: float, speed: float, name: str = "road") -> GroundMotion:
    """The ground motion under a car that drives over a road.

    The profile is the cubic spline through the heights, level at its start; its second derivative is linear
    between them, as a ground motion is, so a car in it follows these heights exactly. Samples are
    spacing/speed seconds apart. A step in the profile becomes a ramp one spacing long.

    Parameters
    ----------
    height
        ``(n,)`` in m, n at least 3.
    spacing
        Between the heights, m, greater than 0.
    speed
        Of the car, m/s, greater than 0.
    name
        What the motion is called.

    Raises
    ------
    InputError
        The heights are too few or not finite, or spacing or speed is not greater than 0.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> bump = dp.structures.road(0.05 * np.hanning(21), spacing=0.1, speed=10.0)
    >>> bump.n, bump.dt
    (21, 0.01)
    """
    from scipy.interpolate import CubicSpline

    y = np.asarray(in_si(height, "m", "height"), dtype=float)
    spacing, speed = in_si(spacing, "m", "spacing"), in_si(speed, "m/s", "speed")
    if y.ndim != 1 or len(y) < 3 or not np.all(np.isfinite(y)):
        raise InputError(f"height has shape {y.shape}; it must be one row of at least 3 finite numbers in m")
    for key, value in (("spacing", spacing), ("speed", speed)):
        if not np.isfinite(value) or value <= 0:
            raise InputError(f"{key} = {value!r} is not allowed; it must be greater than 0")
    dt = spacing / speed
    # level at its start, as the car comes from a level road; without bending at its end, of which nothing is known
    spline = CubicSpline(dt * np.arange(len(y)), y, bc_type=((1, 0.0), (2, 0.0)))
    return GroundMotion(spline(spline.x, 2), dt, name, f"road profile at {speed:g} m/s", ("a road",))


def _chain(first: float, second: float) -> np.ndarray:
    """One element from the ground to floor 1, one from floor 1 to floor 2."""
    return np.array([[first + second, -second], [-second, second]])
