r"""Cars: the quarter car, a wheel on its tyre and a quarter of the body on its suspension, and the half car of two axles.

.. math:: m_u \ddot x_u = k_s (x_s - x_u) + c_s (\dot x_s - \dot x_u) + f - k_t (x_u - y) - c_t (\dot x_u - \dot y),
          \qquad m_s \ddot x_s = -k_s (x_s - x_u) - c_s (\dot x_s - \dot x_u) - f

Every force depends on differences of x_s, x_u and the road's height y alone, the tyre's dashpot too. In
q = x - y the equations are therefore those of a building whose ground moves by y: nothing is neglected, and
only the second derivative of the road is needed.

The half car's body, of mass m and moment of inertia J, stands on the suspensions of two axles, l_f before and l_r behind its
centre of mass. Its coordinates are the heights of the body above the axles, x_f and x_r, of which the heave of the centre of
mass and the pitch are

.. math:: z = \frac{l_r x_f + l_f x_r}{l_f + l_r}, \qquad \theta = \frac{x_f - x_r}{l_f + l_r}, \qquad
          2 T = m \dot z^2 + J \dot\theta^2 + m_f \dot x_{uf}^2 + m_r \dot x_{ur}^2

Each axle is then as the quarter car's, over a road of its own: four differences carry four masses, so slow motions of the
road stretch neither springs nor dashpots, and nothing is neglected here either (`dampyr.structures.supports`).
Angles are small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.structures.building import Building
from dampyr.structures.supports import SupportedBuilding, SupportMotions
from dampyr.units import STANDARD_GRAVITY, in_si

Array = NDArray[np.float64]
AXLES = ("front", "rear")


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


@dataclass(frozen=True, eq=False, repr=False)
class HalfCar(SupportedBuilding):
    """A half car, as `half_car` makes it: ``wheelbase`` [m], and ``centre`` [m], how far the centre of mass lies behind the
    front axle."""

    wheelbase: float = 0.0
    centre: float = 0.0

    def body_at(self, position: float) -> Array:
        """The row (4,) that turns motions of the floors into that of the body ``position`` m behind the front axle."""
        share = float(position) / self.wheelbase
        return np.array([0.0, 1.0 - share, 0.0, share])

    @property
    def pitch(self) -> Array:
        """The row (4,) that turns motions of the floors into the pitch of the body, rad, positive where the front rises."""
        return np.array([0.0, 1.0, 0.0, -1.0]) / self.wheelbase

    @property
    def static_loads(self) -> Array:
        """The weight on each axle (2,), front and rear [N]."""
        return np.asarray(STANDARD_GRAVITY * (self.support_influence.T @ np.asarray(self.M) @ self.influence))

    def tyre_loads(self, displacement: Array, velocity: Array) -> Array:
        """The change of the tyres' forces on the road (2, T) [N] in a response, front and rear, positive where they stretch."""
        wheels = [0, 2]
        spring, dashpot = (np.array([matrix[k, k] + matrix[k, k + 1] for k in wheels]) for matrix in (self.K, self.C))
        return np.asarray(spring[:, None] * displacement[wheels] + dashpot[:, None] * velocity[wheels])


def half_car(
    body: float,
    inertia: float,
    front: float,
    rear: float,
    unsprung: float | Sequence[float],
    suspension: float | Sequence[float],
    tyre: float | Sequence[float],
    damping: float | Sequence[float] = 0.0,
    tyre_damping: float | Sequence[float] = 0.0,
    name: str = "half car",
) -> HalfCar:
    """A half of a car, two wheels one behind the other: heave and pitch of the body, and both wheels.

    Parameters
    ----------
    body
        Mass of the half body, kg, greater than 0.
    inertia
        Its moment of inertia about its centre of mass in pitch, kg m2, greater than 0; m l_f l_r keeps the axles apart.
    front, rear
        l_f and l_r, how far before and behind the centre of mass the axles stand, m, greater than 0.
    unsprung, suspension, tyre
        Mass of a wheel, kg, stiffness of its suspension and of its tyre, N/m, greater than 0: a number for both axles, or a
        pair, front and rear.
    damping, tyre_damping
        Of the suspension without the damper that is to be studied, and of the tyre, N s/m; by default none.
    name
        What the car is called.

    Its floors are "front wheel", "front body", "rear wheel" and "rear body", the body's those above the axles, and it drives
    over `axle_roads`. Dampers stand at ``{("front wheel", "front body"): damper, ("rear wheel", "rear body"): damper}``. In a
    response ``drift`` is (front tyre, front travel, rear tyre, rear travel), ``acceleration`` absolute, ``base_shear`` the
    change of the force of both tyres on the road; displacements and velocities are relative to the road under the axle.
    ``car.body_at(x)`` and ``car.pitch`` are rows for ``row @ response.acceleration``. Tyres never leave the road:
    `ride_figures` says where they would have to pull at it.

    Raises
    ------
    InputError
        A mass, a stiffness or a distance is not greater than 0, or a dashpot is negative.

    Examples
    --------
    >>> import dampyr as dp
    >>> car = dp.structures.half_car(580.0, 900.0, 1.2, 1.4, unsprung=45.0, suspension=(18e3, 20e3), tyre=190e3)
    >>> car.floors, car.frequencies.round(2)
    (('front wheel', 'front body', 'rear wheel', 'rear body'), array([ 1.17,  1.34, 10.83, 10.88]))
    """
    single = {
        key: float(in_si(value, unit, key))
        for key, value, unit in (
            ("body", body, "kg"), ("inertia", inertia, "kg m^2"), ("front", front, "m"), ("rear", rear, "m"),
        )
    }  # fmt: skip
    for key, value in single.items():
        if not np.isfinite(value) or value <= 0:
            raise InputError(f"{key} = {value!r} is not allowed; it must be finite and greater than 0")
    mass, spring, wheel = (
        _of_axles(key, values, unit, True)
        for key, values, unit in (
            ("unsprung", unsprung, "kg"), ("suspension", suspension, "N/m"), ("tyre", tyre, "N/m"),
        )
    )  # fmt: skip
    dashpot, soft = (
        _of_axles(key, values, "N s/m", False) for key, values in (("damping", damping), ("tyre_damping", tyre_damping))
    )
    length = single["front"] + single["rear"]
    heave, pitch = np.array([single["rear"], single["front"]]) / length, np.array([1.0, -1.0]) / length
    M = np.zeros((4, 4))
    M[np.ix_((1, 3), (1, 3))] = single["body"] * np.outer(heave, heave) + single["inertia"] * np.outer(pitch, pitch)
    K, C = np.zeros((4, 4)), np.zeros((4, 4))
    for axle in range(2):
        at = slice(2 * axle, 2 * axle + 2)
        M[2 * axle, 2 * axle] = mass[axle]
        K[at, at], C[at, at] = _chain(wheel[axle], spring[axle]), _chain(soft[axle], dashpot[axle])
    return HalfCar(
        M=M, C=C, K=K, name=name,
        floors=("front wheel", "front body", "rear wheel", "rear body"),
        supports=AXLES, support_influence=np.repeat(np.eye(2), 2, axis=0), below=(0, 1, 0, 3),
        wheelbase=length, centre=single["front"],
    )  # fmt: skip


def _of_axles(key: str, values: float | Sequence[float], unit: str, positive: bool) -> Array:
    """A number of the front and of the rear axle, of one or two given."""
    pair = np.atleast_1d(np.asarray(in_si(values, unit, key), dtype=float))
    low = "greater than 0" if positive else "at least 0"
    if pair.shape not in ((1,), (2,)) or not np.all(np.isfinite(pair)) or np.any(pair <= 0 if positive else pair < 0):
        raise InputError(f"{key} = {values!r} is not allowed; give a number, or front and rear, finite and {low}")
    return np.array(np.broadcast_to(pair, 2))


def axle_roads(height: ArrayLike, spacing: float, speed: float, wheelbase: float, name: str = "road") -> SupportMotions:
    """The motions under the axles of a car that drives over one road: the rear axle comes ``wheelbase`` after the front one.

    Each is as `road` makes it: that of the front axle follows the heights exactly, that of the rear one too where the spacing
    divides the wheelbase, else heights of the spline between them. Before its start the road is level. The motion ends with
    the front axle at the last height.

    Parameters
    ----------
    height, spacing, speed, name
        As in `road`.
    wheelbase
        m, greater than 0, such as ``car.wheelbase`` of `half_car`.

    Raises
    ------
    InputError
        As `road`, or the wheelbase is not greater than 0.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> bump = np.r_[np.zeros(10), 0.05 * np.hanning(21), np.zeros(40)]
    >>> roads = dp.structures.axle_roads(bump, spacing=0.1, speed=10.0, wheelbase=2.6)
    >>> {axle: int(np.argmin(motion.acceleration)) for axle, motion in roads.motions.items()}
    {'front': 20, 'rear': 46}
    """
    from scipy.interpolate import CubicSpline

    front = road(height, spacing, speed, f"{name}, front axle")
    y, spacing = np.asarray(in_si(height, "m", "height"), dtype=float), float(in_si(spacing, "m", "spacing"))
    wheelbase = float(in_si(wheelbase, "m", "wheelbase"))
    if not np.isfinite(wheelbase) or wheelbase <= 0:
        raise InputError(f"wheelbase = {wheelbase!r} is not allowed; it must be finite and greater than 0")
    s = spacing * np.arange(len(y)) - wheelbase
    whole = round(wheelbase / spacing)
    if abs(whole * spacing - wheelbase) <= 1e-9 * wheelbase:
        behind = np.r_[np.full(min(whole, len(y)), y[0]), y][: len(y)]
    else:
        spline = CubicSpline(spacing * np.arange(len(y)), y, bc_type=((1, 0.0), (2, 0.0)))
        behind = np.where(s < 0.0, y[0], spline(np.maximum(s, 0.0)))
    rear = road(behind, spacing, speed, f"{name}, rear axle")
    return SupportMotions(dict(zip(AXLES, (front, rear), strict=True)), name)


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
