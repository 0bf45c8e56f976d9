r"""Prediction of the force that a test meets, before it moves.

With the damper's card it is the damper's force along the planned path. Without one the force is unknown, and a conservative
envelope takes its place: 1.2 times the greatest force of the fit to the original rig's damper,

.. math:: |F| \le 1.2\, (F_0 + k |x| + c |v| + F_y)

with the coefficients of `dampyr.rig.specimen.original_specimen` at the voltages of its fits, linear between and beyond them,
always against the motion.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning
from dampyr.input_kinds import input_arguments
from dampyr.models import Damper, Interpolation
from dampyr.rig import Drive, RigSettings
from dampyr.rig.specimen import original_specimen, specimen_of

Array = NDArray[np.float64]
PASS, SLOW_PASS = 1.0e-3, 0.01  # m on either side of a place, m/s: as `dampyr.rig.session.ArmedRig.verify` goes
FACTOR = 1.2  # the fit's residual is 8 to 11 % rms
COEFFICIENTS = ("offset.f0", "spring.k0", "hyperbolic_tangent.c", "hyperbolic_tangent.ft")  # F0, k, c, Fy
UNKNOWN = (
    "no card of the damper: its force is unknown and taken as a conservative envelope of the original rig's damper"
)


@dataclass(frozen=True)
class Course:
    """Motion and force of a drive at its set points: time, position, speed, acceleration, force, all (n,) SI.

    ``against`` is the part of the force that brakes the table: 0 where the damper drives it.
    """

    t: Array
    x: Array
    v: Array
    a: Array
    force: Array
    notes: tuple[str, ...] = ()

    @property
    def speed(self) -> Array:
        """m/s, the greater one of the straight segments before and after each set point."""
        pieces = np.abs(np.diff(self.x)) / (self.t[1] - self.t[0])
        return np.maximum(np.append(pieces, 0.0), np.insert(pieces, 0, 0.0))

    @property
    def energy(self) -> float:
        """J dissipated by the force, the integral of F dx."""
        return float(np.sum(0.5 * (self.force[1:] + self.force[:-1]) * np.diff(self.x)))

    @property
    def against(self) -> Array:
        """N, at least 0."""
        return np.maximum(self.force * np.sign(self.v), 0.0)


def specimen(rig: RigSettings, folder: str | Path | None = None) -> Damper | None:
    """The damper whose card the rig names, relative to ``folder``.

    Where it names none: the simulated rig's own damper, and None for a real rig.
    """
    if rig.specimen.card or not rig.wires.serial:
        return specimen_of(rig, folder)
    return None


def course(drive: Drive, rig: RigSettings, damper: Damper | None) -> Course:
    """The motion and force of the drive; :class:`~dampyr.errors.RangeError` for a voltage outside the damper's range."""
    x, u = _planned_path(drive, rig)
    t = np.arange(x.size, dtype=np.float64) * drive.period
    v = np.asarray(np.gradient(x, drive.period), dtype=float)
    a = np.asarray(np.gradient(v, drive.period), dtype=float)
    if damper is None:
        return Course(t, x, v, a, np.copysign(envelope(x, v, u), v))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DampyrWarning)
        value = u / rig.supply.resistance if damper.input == "A" else u
        force = damper.force_of_motion(t, x, velocity=v, **input_arguments(damper.input, value))
    notes = tuple(
        dict.fromkeys(str(warning.message) for warning in caught if issubclass(warning.category, DampyrWarning))
    )
    return Course(t, x, v, a, force, notes)


def mean_force_at(damper: Damper, place: float) -> float | None:
    """The mean of the forces [N] on a slow way down and up again over ``place`` [m] at 0 V, that a card promises; None where it
    does not hold for 0 V."""
    low, _ = damper.range
    if low > 0.0:
        return None
    way = np.linspace(PASS, -PASS, 200)
    x = place + np.concatenate([-way, way, -way])
    t = np.arange(x.size) * PASS / 200.0 / SLOW_PASS
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        zero = input_arguments(damper.input, np.zeros(x.size))
        force = damper.force_of_motion(t, x, velocity=np.gradient(x, t), **zero)
    return float(0.5 * sum(np.mean(force[first + 50 : first + 150]) for first in (200, 400)))


@cache
def original_fit() -> Array:
    """The fits to the original rig's damper, one row per voltage: V, F0 [N], k [N/m], c [N s/m], Fy [N]."""
    laws = original_specimen().all_laws
    columns = [law for law in map(laws.get, COEFFICIENTS) if isinstance(law, Interpolation)]
    return np.column_stack([columns[0].knots, *(law.values for law in columns)])


def envelope(x: Array, v: Array, voltage: Array) -> Array:
    """The conservative envelope of the force [N], see above."""
    u = np.asarray(voltage, dtype=float)
    fits = original_fit()
    k = np.clip(np.searchsorted(fits[:, 0], u, side="right") - 1, 0, len(fits) - 2)
    share = ((u - fits[k, 0]) / (fits[k + 1, 0] - fits[k, 0]))[..., None]
    F0, stiffness, damping, Fy = np.moveaxis(fits[k, 1:] + share * (fits[k + 1, 1:] - fits[k, 1:]), -1, 0)
    return np.asarray(FACTOR * (F0 + stiffness * np.abs(x) + damping * np.abs(v) + Fy))


def _planned_path(drive: Drive, rig: RigSettings) -> tuple[Array, Array]:
    """The planned path; for timed reversals that of an unloaded actuator from the middle."""
    timed = drive.reversals
    if timed is None:
        return drive.displacement, drive.voltage
    t, stroke_time = np.arange(drive.n) * drive.period, timed.half_period + timed.pause
    stroke, since = np.divmod(t, stroke_time)
    share = np.minimum(2 * np.minimum(since, stroke_time - since) / timed.half_period, 1.0) * (stroke < timed.count)
    v = np.where(stroke % 2, -1.0, 1.0) * share * timed.duty * rig.actuator.free_speed
    return np.asarray(np.cumsum(v) * drive.period), drive.voltage
