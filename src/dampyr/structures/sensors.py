r"""What a controller can measure in a building and at its damper, and how far its sensors are from the truth.

Every measure is linear in what a time step knows, :math:`w = (q, \dot q, \dot x_g, a_g, f_1 \dots f_N)`: the state of the
building relative to the ground, the ground's velocity and acceleration, and the forces of the dampers; where there are loads
(`dampyr.structures.time_history.loading`), their integrals, of supports their velocities, and the loads follow. A sensor gives

.. math:: y_k = \mathrm{quantised}\big(\mathrm{clip}(m_{k-d} + b + \sigma n_k, \pm r)\big)

of the measure m at the law's sample k, d samples late, with the bias b, white noise of the standard deviation sigma, the range
r and the quantum of its converter. The noise is a function of the seed, the damper's site, the channel and the sample
(`dampyr.structures.sensor_noise`), so that two runs at different steps have the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.structures.building import Building
from dampyr.structures.propagator import system
from dampyr.structures.supports import SupportedBuilding

Array = NDArray[np.float64]
MAX_DELAY = 200  # samples of a law


@dataclass(frozen=True)
class Sensor:
    """A sensor of a measure: ``noise`` (standard deviation of each sample), ``bias``, ``quantum`` and ``range``, in the unit of
    the measure, and ``delay``, in samples of the law. 0 is none; a range is infinite unless it is given.

    Raises :class:`~dampyr.errors.InputError` for numbers that are negative (but for the bias) or not finite.
    """

    noise: float = 0.0
    bias: float = 0.0
    quantum: float = 0.0
    range: float = math.inf
    delay: int = 0

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, _checked(field.name, getattr(self, field.name)))

    @property
    def is_ideal(self) -> bool:
        """Whether it gives what it measures."""
        return self == Sensor()

    def in_words(self, measure: str) -> str:
        """What it is, for labels: "force noise 3 N, 1 sample late"."""
        unit = f" {MEASURES[measure].unit}".replace("^2", "²")
        said = [f"{name} {getattr(self, name):g}{unit}" for name in ("noise", "bias", "quantum") if getattr(self, name)]
        said += [f"range {self.range:g}{unit}"] if math.isfinite(self.range) else []
        said += [f"{self.delay} sample{'s' if self.delay > 1 else ''} late"] if self.delay else []
        return f"{measure} {', '.join(said)}" if said else ""


def _checked(name: str, value: Any) -> float | int:
    """One number of a sensor, checked."""
    allowed = {"bias": "a finite number", "range": "greater than 0", "delay": f"a whole number from 0 to {MAX_DELAY}"}
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    good = {
        "bias": math.isfinite(number),
        "range": number > 0.0,
        "delay": 0 <= number <= MAX_DELAY and number == int(number) if math.isfinite(number) else False,
    }.get(name, 0.0 <= number < math.inf)
    if not good:
        raise InputError(f"{name} = {value!r} of a sensor is not allowed; it must be {allowed.get(name, 'at least 0')}")
    return int(number) if name == "delay" else number


@dataclass(frozen=True)
class Measure:
    """A quantity that can be measured: its ``unit``, what it is, and ``rows(place)``, its rows over w (k, 2n + 2 + N)."""

    unit: str
    about: str
    rows: Callable[[DamperPlace], Array]


@dataclass(frozen=True, eq=False)
class DamperPlace:
    """Where a controller stands: damper ``d`` of those at ``connections`` (N, n) in ``building``.

    ``loads`` are those of the response (`dampyr.structures.time_history.loading.Loads`), None for none.
    """

    building: Building
    connections: Array
    d: int
    loads: Any = None

    @property
    def carried(self) -> Array:
        """What of the loads' integrals is in absolute velocities (n, r)."""
        return np.zeros((self.building.n, 0)) if self.loads is None else np.asarray(self.loads.carried)

    @property
    def seen(self) -> Array:
        """What of the loads is in absolute accelerations (n, r)."""
        return np.zeros((self.building.n, 0)) if self.loads is None else np.asarray(self.loads.seen)

    @property
    def row(self) -> Array:
        """What turns floor displacements into the damper's stroke (n,)."""
        return np.asarray(self.connections[self.d])

    @property
    def before_loads(self) -> int:
        """How many numbers of w come before the loads."""
        return 2 * self.building.n + 2 + len(self.connections)

    @property
    def width(self) -> int:
        """How many numbers w has."""
        return self.before_loads + 2 * self.carried.shape[1]

    def over(self, q: Any = None, v: Any = None, ground: float = 0.0, moved: Any = None) -> Array:
        """One row over w: of the displacements, the velocities, the ground's velocity, and those of supports by which the
        coordinates ``moved`` (n,) move."""
        n, loads = self.building.n, self.carried.shape[1]
        row = np.zeros((1, self.width))
        row[0, :n], row[0, n : 2 * n], row[0, 2 * n] = 0.0 if q is None else q, 0.0 if v is None else v, ground
        if moved is not None:
            row[0, self.before_loads : self.before_loads + loads] = np.asarray(moved) @ self.carried
        return row

    def accelerations(self) -> Array:
        """The absolute accelerations of all coordinates (n, 2n + 2 + N + 2r)."""
        n = self.building.n
        a, _, b = system(self.building, self.connections)
        direct = np.asarray(self.building.ground_terms()[0]).reshape(-1, 1)
        return np.hstack([a[n:], np.zeros((n, 1)), direct, b[n:], np.zeros_like(self.seen), self.seen])

    def end(self, upper: bool) -> tuple[int | None, float]:
        """The coordinate of the damper's upper or lower end and its share in the stroke; None is the ground."""
        ends = np.flatnonzero(self.row)
        if upper:
            return int(ends[-1]), float(self.row[ends[-1]])
        return (int(ends[0]), float(self.row[ends[0]])) if len(ends) > 1 else (None, -1.0)

    def velocity(self, upper: bool) -> Array:
        """The absolute velocity of an end, positive where it lengthens the damper."""
        k, share = self.end(upper)
        unit = np.zeros(self.building.n)
        if k is None:  # a support moves as the floor on it would that follows it alone
            upper_end = self.end(True)[0]
            assert upper_end is not None
            unit[upper_end] = share
            return self.over(ground=share, moved=unit)
        unit[k] = share
        return self.over(v=unit, ground=share * float(self.building.carried[k]), moved=unit)

    def acceleration(self) -> Array:
        """The absolute acceleration of the upper end, positive where it lengthens the damper."""
        k, share = self.end(upper=True)
        assert k is not None  # an upper end is a floor
        return share * self.accelerations()[[k]]


def _unit_row(size: int, at: int) -> Array:
    row = np.zeros((1, size))
    row[0, at] = 1.0
    return row


def _of_ground(place: DamperPlace, at: int) -> Array:
    if at < 2 and isinstance(place.building, SupportedBuilding):
        raise InputError(
            f"{place.building.name} stands on several supports, and a law that measures the ground knows one; take another law"
        )
    return _unit_row(place.width, 2 * place.building.n + at)


MEASURES: dict[str, Measure] = {
    "stroke": Measure("m", "stroke of the damper", lambda p: p.over(q=p.row)),
    "rate": Measure("m/s", "rate of the stroke", lambda p: p.over(v=p.row)),
    "absolute_rate": Measure(
        "m/s",
        "rate of the stroke where the ground counts as still",
        lambda p: p.over(v=p.row, ground=float(p.row @ p.building.carried), moved=p.row),
    ),
    "force": Measure("N", "force of the damper, positive against positive rate", lambda p: _of_ground(p, 2 + p.d)),
    "velocity": Measure(
        "m/s", "absolute velocity of the damper's upper end, positive where it lengthens", lambda p: p.velocity(True)
    ),
    "lower_velocity": Measure(
        "m/s", "absolute velocity of its lower end, positive where it lengthens", lambda p: p.velocity(False)
    ),
    "acceleration": Measure(
        "m/s^2", "absolute acceleration of its upper end, positive where it lengthens", lambda p: p.acceleration()
    ),
    "accelerations": Measure(
        "m/s^2", "absolute accelerations of all floors", lambda p: p.accelerations()[: p.building.n_floors]
    ),
    "state": Measure(
        "m, m/s",
        "displacements and velocities of all floors relative to the ground",
        lambda p: np.eye(2 * p.building.n, p.width),
    ),
    "ground_velocity": Measure("m/s", "velocity of the ground", lambda p: _of_ground(p, 0)),
    "ground_acceleration": Measure("m/s^2", "acceleration of the ground", lambda p: _of_ground(p, 1)),
}
"""What a law can measure, by name."""
VECTORS = ("accelerations", "state")  # of more than one number: a law uses them through the signals of its design
