r"""The level of a damper's force, tracked cycle by cycle while it runs, with an alarm when the damper has changed.

The measured dynamic force is a multiple of the card's: :math:`F = (a - c\,\Delta T)\,F_\text{card}`. a is the level at the
temperature of the start and c what a kelvin takes off it; :math:`\Delta T` is the warming by the heat that went in and was
lost,

.. math:: C \dot T = F v - h (T - T_r)

Once a cycle the ratio :math:`y = \sum F_\text{card} F / \sum F_\text{card}^2` is one observation of
:math:`a - c\,\Delta T`: what the card misses is correlated over a cycle, so that the samples of one are not as many
observations. Its standard deviation from cycle to cycle is the ``scatter``. A Kalman filter with the states (a, c) follows it;
a moves by ``drift`` a cycle.

The alarm is Page's cumulative sum of the filter's innovations in both directions, with half of the stated ``loss`` as
reference value. Its limit is that of Siegmund's approximation for one false alarm in ``false_alarm_cycles`` cycles.

References: R. E. Kalman, A new approach to linear filtering and prediction problems, Journal of Basic Engineering 82 (1960)
35-45; E. S. Page, Continuous inspection schemes, Biometrika 41 (1954) 100-115; D. Siegmund, Sequential Analysis, Springer
(1985), equation (2.57).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, isfinite, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.input_kinds import INPUTS
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind
from dampyr.models.path_integration import integrate_force
from dampyr.units import in_si

Array = NDArray[np.float64]
LEVEL, SOFTENING = 0.08, 0.005  # standard deviations before the first cycle: of a, as between sessions, and of c in 1/K
BAND = 0.1  # of the largest speed so far, which the velocity passes on both sides in a cycle


@dataclass(frozen=True)
class LevelAlarm:
    """A change of the damper: the ``time`` s and the number of the ``cycle`` at which it was flagged, in how many cycles the
    sum rose to its limit (``since``), the level expected ``before`` and that of the cycle; ``reason`` says it in a sentence."""

    time: float
    cycle: int
    since: int
    before: float
    level: float
    reason: str


@dataclass(frozen=True)
class TrackedLevel:
    """Arrays (n,) after each sample: the corrected ``force`` N, of which no later sample is known; the ``level`` of the dynamic
    force over the card's and its standard deviation ``level_std``, the ``temperature`` degC by the heat that went in, and the
    ``alarms`` among these samples."""

    force: Array
    level: Array
    level_std: Array
    temperature: Array
    alarms: tuple[LevelAlarm, ...]


class LevelTracker:
    """A card that follows its damper: `track_level` makes it, ``update`` takes a sample, ``along`` many.

    ``level`` and ``level_std`` are the multiplier of the card's dynamic force at the present temperature and its standard
    deviation, ``temperature`` the damper's in degC, ``cycles`` how many were seen, ``alarms`` all changes so far.
    """

    def __init__(
        self,
        damper: Damper,
        loss: float,
        scatter: float,
        drift: float,
        false_alarm_cycles: float,
        heat: tuple[float, ...] | None,
    ) -> None:
        self.damper, self.loss, self.scatter, self.drift, self.heat = damper, loss, scatter, drift, heat
        self.reference = 0.5 * loss / scatter
        self.limit = siegmund_limit(self.reference, false_alarm_cycles)
        self._state, self._covariance = np.array([1.0, 0.0]), np.diag([LEVEL**2, SOFTENING**2])
        self._states = np.array(damper.composition.path0, dtype=float)
        self._start = self.temperature = heat[2] if heat else 0.0
        self.cycles, self.time, self.alarms = 0, 0.0, []  # type: tuple[int, float, list[LevelAlarm]]
        self._last: tuple[float, float] | None = None
        self._products, self._squares, self._fastest, self._side, self._turns = 0.0, 0.0, 0.0, 0, 0
        self._sums, self._since = [0.0, 0.0], [0, 0]

    @property
    def _design(self) -> Array:
        return np.array([1.0, self._start - self.temperature])

    @property
    def level(self) -> float:
        """The multiplier of the card's dynamic force at the present temperature."""
        return float(self._design @ self._state)

    @property
    def level_std(self) -> float:
        """The standard deviation of ``level``."""
        return sqrt(float(self._design @ self._covariance @ self._design))

    def update(
        self, displacement: float, velocity: float, force: float, dt: float, input: float | None = None
    ) -> float:
        """Take a sample, ``dt`` s after the last: m, m/s, the measured N, the input at the coil in V or A where there is
        one; the corrected force in N, as it was predicted before this sample's force was seen."""
        tracked = self.along([dt], [displacement], [velocity], [force], input)
        return float(tracked.force[0])

    def along(
        self,
        dt: ArrayLike,
        displacement: ArrayLike,
        velocity: ArrayLike,
        force: ArrayLike,
        input: ArrayLike | None = None,
    ) -> TrackedLevel:
        """Take samples (n,), each ``dt`` s (a number or (n,)) after the one before."""
        x = np.atleast_1d(np.asarray(in_si(displacement, "m", "displacement"), dtype=float))
        columns = [
            np.broadcast_to(np.asarray(in_si(values, unit, name), dtype=float), x.shape)
            for values, unit, name in ((velocity, "m/s", "velocity"), (force, "N", "force"), (dt, "s", "dt"))
        ]
        v, measured, steps = columns
        if not all(np.all(np.isfinite(values)) for values in (x, *columns)) or np.any(steps <= 0.0):
            raise InputError(
                "displacement, velocity and force must be finite, and dt greater than 0 s; leave such samples out"
            )
        if input is None and self.damper.needs_input:
            raise InputError(
                f"this damper needs its {INPUTS[self.damper.input]} at each sample; pass input= in {self.damper.input}"
            )
        if input is not None and not self.damper.has_input:
            raise InputError("this damper has no input, so a sample has none; leave input= out")
        applied = 0.0 if input is None else in_si(input, self.damper.input, INPUTS[self.damper.input])
        u = np.broadcast_to(np.asarray(applied, dtype=float), x.shape)
        card, rest = self._card_force(x, v, steps, u)
        before, rows = len(self.alarms), np.empty((4, x.size))
        samples = zip(steps.tolist(), v.tolist(), card.tolist(), (measured - rest).tolist(), strict=True)
        for k, sample in enumerate(samples):
            rows[0, k] = rest[k] + self.level * card[k]
            self._take(*sample)
            rows[1:, k] = self.level, self.level_std, self.temperature
        predicted, level, std, degrees = rows
        return TrackedLevel(predicted, level, std, degrees, tuple(self.alarms[before:]))

    def _card_force(self, x: Array, v: Array, dt: Array, u: Array) -> tuple[Array, Array]:
        """The card's dynamic force (n,) and its static one, from the states at the last sample; these go on."""
        composition = self.damper.composition
        moves = bool(self.damper.needs_input and np.ptp(u))
        values = self.damper.values(u if moves else u[0])
        static = list(composition.static)
        rest = np.broadcast_to(np.asarray(values[..., static].sum(axis=-1)), x.shape)
        values = np.array(np.broadcast_to(values, (x.size, values.shape[-1])))
        values[:, static] = 0.0
        x0, v0 = self._last or (x[0], v[0])
        t = np.concatenate([[0.0], np.cumsum(dt)])
        path = (t, np.append(x0, x), np.append(v0, v), np.zeros(t.size))
        out = np.empty(t.size)
        bind(integrate_force, (composition,))(
            *path, np.ascontiguousarray(values[np.r_[0, : x.size]]), self._states, out
        )
        self._last = (float(x[-1]), float(v[-1]))
        return out[1:], rest

    def _take(self, dt: float, v: float, card: float, dynamic: float) -> None:
        self.time += dt
        if self.heat:
            capacity, cooling, room = self.heat
            self.temperature += dynamic * v * dt / capacity
            self.temperature = room + (self.temperature - room) * exp(-cooling / capacity * dt)
        self._products += card * dynamic
        self._squares += card * card
        self._fastest = max(self._fastest, abs(v))
        side = (v > BAND * self._fastest) - (v < -BAND * self._fastest)
        if side and side != self._side:
            self._side, self._turns = side, self._turns + 1
            if self._turns > 2 and self._squares > 0.0:  # both ways were gone
                self._observe(self._products / self._squares)
                self._products, self._squares, self._turns = 0.0, 0.0, 1

    def _observe(self, ratio: float) -> None:
        """Take the ratio of a cycle."""
        self.cycles += 1
        predicted, design, covariance = self.level, self._design, self._covariance
        covariance[0, 0] += self.drift**2
        variance = float(design @ covariance @ design) + self.scatter**2
        innovation = (ratio - predicted) / sqrt(variance)
        gain = covariance @ design / variance
        self._state = self._state + gain * (ratio - predicted)
        self._covariance = covariance - np.outer(gain, gain) * variance
        for k, sign in enumerate((-1.0, 1.0)):
            self._sums[k] = max(0.0, self._sums[k] + sign * innovation - self.reference)
            self._since[k] = self._since[k] + 1 if self._sums[k] else 0
        k = int(self._sums[1] > self._sums[0])
        if self._sums[k] > self.limit:
            self._flag(predicted, ratio, self._since[k])

    def _flag(self, before: float, ratio: float, since: int) -> None:
        """Note the change, and begin anew at the level of this cycle."""
        reason = (
            f"the force is {ratio:.3g} of the card's where {before:.3g} was expected, {ratio / before - 1.0:+.1%}: look at the "
            "damper, its mounting and the coil"
        )
        self.alarms.append(LevelAlarm(self.time, self.cycles, since, before, ratio, reason))
        self._state[0] += ratio - self.level
        self._covariance[0, 0] += self.scatter**2
        self._sums, self._since = [0.0, 0.0], [0, 0]


def siegmund_limit(reference: float, cycles: float) -> float:
    r"""The limit h of cumulative sums of unit normal numbers in both directions, for a mean of ``cycles`` numbers before a
    false alarm: Siegmund's (exp(2 k b) - 2 k b - 1)/(2 k^2) = 2 cycles, b = h + 1.166."""
    from scipy.optimize import brentq

    def lack(b: float) -> float:
        return float(np.expm1(2.0 * reference * b) - 2.0 * reference * b) / (2.0 * reference**2) - 2.0 * cycles

    return max(0.5, float(brentq(lack, 1e-9, 40.0 / reference)) - 1.166)


def track_level(
    damper: Damper,
    loss: float = 0.10,
    scatter: float = 0.02,
    drift: float = 0.001,
    false_alarm_cycles: float = 10_000.0,
    heat_capacity: float | None = None,
    cooling: float = 0.0,
    room: float = 20.0,
) -> LevelTracker:
    """A tracker of the level of ``damper``, which takes samples one by one or as arrays.

    Parameters
    ----------
    damper
        the card; its force may not be delayed, nor its input lag.
    loss
        the share of the force whose sudden loss, or gain, is to be flagged.
    scatter
        standard deviation of the level from cycle to cycle: what the card misses, which changes from motion to motion.
    drift
        how far the level may move in a cycle without an alarm: standard deviation of its random walk.
    false_alarm_cycles
        mean number of cycles between false alarms, if the cycles scatter independently.
    heat_capacity, cooling, room
        J/K, W/K and degC of the damper, for the temperature; without a heat capacity there is none, and warming is drift.

    Raises
    ------
    InputError
        a number that is not allowed, or a damper with a delay, a lag or a part that needs the acceleration.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.arange(0.0, 30.0, 0.01)
    >>> x, v = 0.008 * np.sin(2 * np.pi * t), 0.008 * 2 * np.pi * np.cos(2 * np.pi * t)
    >>> force = np.where(t < 20.0, 1.0, 0.9) * damper.force(t, x, voltage=1.98, velocity=v)
    >>> tracker = dp.identification.track_level(damper)
    >>> tracked = tracker.along(0.01, x, v, force, 1.98)
    >>> [round(alarm.time) for alarm in tracked.alarms], round(tracker.level, 2)
    ([22], 0.9)
    """
    for name, value in {"loss": loss, "scatter": scatter, "false_alarm_cycles": false_alarm_cycles}.items():
        if not (isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value:g} is not allowed; it must be greater than 0")
    for name, value in {"drift": drift, "cooling": cooling}.items():
        if not (isfinite(value) and value >= 0.0):
            raise InputError(f"{name} = {value:g} is not allowed; it must be 0 or greater")
    if heat_capacity is not None and not 0.0 < heat_capacity < inf:
        raise InputError(f"heat_capacity = {heat_capacity:g} J/K is not allowed; it must be greater than 0")
    composition = damper.composition
    for name, has in (("delay", composition.has_delay), ("lag", composition.lag is not None)):
        if has:
            raise InputError(
                f"the part {name} cannot be tracked sample by sample; track damper.without({name!r}), and give it the force or "
                "the acting input of the sample"
            )
    if inertial := [p.name for p in composition.parts if p.needs_acceleration]:
        raise InputError(
            f"{inertial[0]} needs the acceleration, which a tracker is not given; track damper.without({inertial[0]!r})"
        )
    heat = None if heat_capacity is None else (heat_capacity, cooling, room)
    return LevelTracker(damper, loss, scatter, drift, false_alarm_cycles, heat)
