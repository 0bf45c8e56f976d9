r"""How a vehicle rides: what its passengers feel, what its suspension needs, how its tyre holds to the road.

The acceleration of the body is weighted as ISO 2631-1 (1997) weights vertical vibration of seated people, by the product of

.. math:: \frac{s^2}{s^2 + \frac{\omega_1}{Q} s + \omega_1^2},\quad
          \frac{\omega_2^2}{s^2 + \frac{\omega_2}{Q} s + \omega_2^2},\quad
          \frac{s + \omega_3}{s^2 + \frac{\omega_4}{Q_4} s + \omega_4^2} \frac{\omega_4^2}{\omega_3},\quad
          \frac{s^2 + \frac{\omega_5}{Q_5} s + \omega_5^2}{s^2 + \frac{\omega_6}{Q_6} s + \omega_6^2}

with 0.4, 100, 12.5, 12.5, 2.37 and 3.35 Hz, :math:`Q = 1/\sqrt 2`, :math:`Q_4` = 0.63, :math:`Q_5 = Q_6` = 0.91. Known from
programs that agree with the table of factors that papers print of the standard (482 thousandths at 1 Hz, 1039 at 5 Hz, 405 at
31.5 Hz); its text was not read.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.structures.time_history.response import Response
from dampyr.structures.vehicle import AXLES, HalfCar
from dampyr.units import STANDARD_GRAVITY, in_si

Array = NDArray[np.float64]
BAND = (0.4, 100.0, math.sqrt(0.5))  # Hz, Hz, Q: what is let through
TRANSITION = (12.5, 12.5, 0.63)  # from acceleration to velocity
STEP_UP = (2.37, 0.91, 3.35, 0.91)
RUNNING = 1.0  # s of the running mean of the greatest transient value


def vertical_weighting(frequency: ArrayLike) -> Array:
    """The factor by which ISO 2631-1 weights a vertical acceleration of this frequency (n,) in Hz: W_k, without phase."""
    return np.asarray(np.abs(_transfer(np.asarray(frequency, dtype=float))))


def _transfer(frequency: Array) -> NDArray[np.complex128]:
    s = 2j * np.pi * frequency
    w1, w2, w3, w4, w5, w6 = (2.0 * np.pi * f for f in (*BAND[:2], *TRANSITION[:2], STEP_UP[0], STEP_UP[2]))
    q, q4, q5, q6 = BAND[2], TRANSITION[2], STEP_UP[1], STEP_UP[3]
    high_pass = s**2 / (s**2 + w1 / q * s + w1**2)
    low_pass = w2**2 / (s**2 + w2 / q * s + w2**2)
    transition = (s + w3) / (s**2 + w4 / q4 * s + w4**2) * w4**2 / w3
    step = (s**2 + w5 / q5 * s + w5**2) / (s**2 + w6 / q6 * s + w6**2)
    return np.asarray(high_pass * low_pass * transition * step)


def weighted_acceleration(acceleration: ArrayLike, dt: float) -> Array:
    """A vertical acceleration (n,) in m/s2 as a seated person feels it, by W_k of ISO 2631-1; samples ``dt`` s apart.

    The record is taken to begin and end at rest. Raises :class:`~dampyr.errors.InputError` for what is no row of finite
    numbers, and for samples further apart than 5 ms, as the weighting reaches to 100 Hz.
    """
    a, dt = np.asarray(in_si(acceleration, "m/s^2", "acceleration"), dtype=float), float(in_si(dt, "s", "dt"))
    if a.ndim != 1 or a.size < 2 or not np.all(np.isfinite(a)):
        raise InputError(f"acceleration has shape {a.shape}; it must be one row of finite numbers in m/s2")
    if not 0.0 < dt <= 0.005:
        raise InputError(
            f"dt = {dt:g} s is not allowed; W_k reaches to 100 Hz and needs samples at most 0.005 s apart: give a smaller "
            "spacing of the road's heights"
        )
    rest = math.ceil(10.0 / dt)  # s in which the slowest pole, of 0.4 Hz, comes to rest: the transform is periodic
    n = a.size + rest
    weights = _transfer(np.asarray(np.fft.rfftfreq(n, dt), dtype=np.float64))
    return np.asarray(np.fft.irfft(np.fft.rfft(a, n) * weights, n)[: a.size])


@dataclass(frozen=True)
class AxleFigures:
    """Travel, tyre load and static load of one axle of a half car, SI, as `RideFigures` calls them."""

    travel: float
    peak_travel: float
    tyre_load: float
    peak_tyre_load: float
    static_load: float
    off_road: float


@dataclass(frozen=True, repr=False)
class RideFigures(Shown):
    """Figures of a ride, SI.

    Of a half car the acceleration is that of the body at a position; travel and peak travel are the larger ones of its axles,
    and what is of the tyre is of the axle whose load changes by the larger share of its weight. ``axles`` has both.

    Attributes
    ----------
    weighted_acceleration
        rms of the body's vertical acceleration, weighted by W_k, m/s2: below 0.315 "not uncomfortable", above 2 "extremely
        uncomfortable" in the words of ISO 2631-1.
    acceleration, peak_acceleration
        rms and largest magnitude without weighting, m/s2.
    transient, vibration_dose
        Largest running rms of the weighted acceleration over 1 s, m/s2, and the fourth-power dose, m/s^1.75.
    travel, peak_travel
        rms and largest magnitude of the suspension's travel from its static place, m.
    tyre_load, peak_tyre_load
        rms and largest magnitude of the change of the tyre's force on the road, N.
    static_load
        The weight on the tyre, N.
    off_road
        Share of the time in which the tyre would have to pull at the road, where a real one leaves it: the other figures do not
        hold then, which is one of the findings.
    axles
        The `AxleFigures` of the front and the rear axle of a half car; of a quarter car none.
    pitch_acceleration
        rms of the body's pitch, rad/s2, of a half car; of a quarter car None.
    findings
        What a person should look at in the response, and in these figures, the worst first.
    """

    weighted_acceleration: float
    acceleration: float
    peak_acceleration: float
    transient: float
    vibration_dose: float
    travel: float
    peak_travel: float
    tyre_load: float
    peak_tyre_load: float
    static_load: float
    off_road: float
    axles: Mapping[str, AxleFigures] = field(default_factory=dict)
    pitch_acceleration: float | None = None
    findings: tuple[Finding, ...] = ()


def ride_figures(response: Response, car: Building, start: float = 0.0, position: float | None = None) -> RideFigures:
    """The figures of a ride: of a response of `dampyr.structures.quarter_car` on a `dampyr.structures.road`, or of
    `dampyr.structures.half_car` on `dampyr.structures.axle_roads`.

    Parameters
    ----------
    response, car
        What `respond` gave for the car.
    start
        s from which on figures count, such as the lead of a random road over the speed.
    position
        Of a half car: where on the body the acceleration is felt, m behind the front axle, such as that of a seat; by default
        at the centre of mass.

    Raises
    ------
    InputError
        The building is no car, nothing is left after ``start``, samples are more than 5 ms apart, or a quarter car is given a
        position.

    Examples
    --------
    >>> import dampyr as dp
    >>> car = dp.structures.quarter_car(320.0, 40.0, suspension=22e3, tyre=190e3, damping=1500.0)
    >>> heights = dp.structures.random_road("C", length=200.0, seed=1)
    >>> road = dp.structures.road(heights, spacing=0.05, speed=20.0)
    >>> figures = dp.structures.ride_figures(dp.structures.respond(car, road), car, start=0.5)
    >>> print(f"{figures.weighted_acceleration:.2f} m/s2, {100 * figures.tyre_load / figures.static_load:.0f} %")
    1.17 m/s2, 22 %
    """
    half = isinstance(car, HalfCar)
    if (not half and tuple(response.floors) != ("unsprung", "sprung")) or tuple(car.floors) != tuple(response.floors):
        raise InputError(
            f"the response has the floors {', '.join(response.floors)}; give one of a quarter car, unsprung and sprung, or of "
            "a half car, with that car"
        )
    start = float(in_si(start, "s", "start"))
    first = int(np.searchsorted(response.time, start - 1e-9))
    if response.time.size - first < 2:
        raise InputError(
            f"start = {start:g} s leaves nothing of a ride of {response.time[-1]:g} s; give an earlier one"
        )
    dt, part = float(response.time[1] - response.time[0]), slice(first, None)
    if isinstance(car, HalfCar):
        body, pitch = _body_of(car, response, position), _rms((car.pitch @ response.acceleration)[part])
        loads = car.tyre_loads(response.displacement, response.velocity)
        axles = {
            name: _axle(response.drift[2 * k + 1][part], loads[k][part], float(car.static_loads[k]))
            for k, name in enumerate(AXLES)
        }
    else:
        if position is not None:
            raise InputError(
                f"position = {position!r} is of a half car, and {car.name} is a quarter of one; leave it out"
            )
        body, pitch = response.acceleration[1], None
        static = float(np.trace(car.M)) * STANDARD_GRAVITY
        axles = {"": _axle(response.drift[1][part], response.base_shear[part], static)}
    felt = weighted_acceleration(body, dt)[part]
    window = max(1, round(RUNNING / dt))
    total = np.cumsum(np.r_[0.0, felt**2])
    running = (total[window:] - total[:-window]) / window if felt.size >= window else total[-1:] / felt.size
    worst = max(axles.values(), key=lambda axle: axle.tyre_load / axle.static_load)
    pulls = [
        Finding(
            "doubt",
            f"the {name}{' ' * bool(name)}tyre would have to pull at the road for {100.0 * axle.off_road:.2g} % of the time, "
            "and a real one leaves it",
        )
        for name, axle in axles.items()
        if axle.off_road
    ]
    return RideFigures(
        weighted_acceleration=_rms(felt),
        acceleration=_rms(body[part]),
        peak_acceleration=float(np.abs(body[part]).max()),
        transient=float(np.sqrt(running.max())),
        vibration_dose=float((np.sum(felt**4) * dt) ** 0.25),
        travel=max(axle.travel for axle in axles.values()),
        peak_travel=max(axle.peak_travel for axle in axles.values()),
        tyre_load=worst.tyre_load,
        peak_tyre_load=worst.peak_tyre_load,
        static_load=worst.static_load,
        off_road=worst.off_road,
        axles=axles if half else {},
        pitch_acceleration=pitch,
        findings=worst_first(response.findings, pulls),
    )


def _body_of(car: HalfCar, response: Response, position: float | None) -> Array:
    """The vertical acceleration (T,) of the body of a half car at a position."""
    place = car.centre if position is None else float(in_si(position, "m", "position"))
    if not math.isfinite(place):
        raise InputError(
            f"position = {position!r} is not allowed; it must be a finite number of m behind the front axle"
        )
    return np.asarray(car.body_at(place) @ response.acceleration)


def _axle(travel: Array, load: Array, static: float) -> AxleFigures:
    return AxleFigures(
        _rms(travel), float(np.abs(travel).max()), _rms(load), float(np.abs(load).max()), static,
        off_road=float(np.mean(load > static)),  # positive where the tyre is stretched
    )  # fmt: skip


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
