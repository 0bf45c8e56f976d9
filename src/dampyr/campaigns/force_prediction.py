r"""The force that a test is expected to meet, before it moves.

With the damper's card it is the damper's force along the planned path. Without one the force is not known, and a conservative
envelope stands for it: 1.2 times the greatest force of the fit to the original rig's damper,

.. math:: |F| \le 1.2\, (F_0 + k |x| + c |v| + F_y)

with the coefficients of the table below, straight between its voltages and beyond them, always against the motion.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning
from dampyr.models import Damper
from dampyr.rig import Drive, RigSettings
from dampyr.rig.simulation.specimen import specimen_of

Array = NDArray[np.float64]
FACTOR = 1.2  # the fit's residual is 8 to 11 % rms
FIT = np.array([  # V, F0 [N], k [N/m], c [N s/m], Fy [N]: the measured records of the original rig, one fit per voltage
    [0.0, 134.0, 910.0, 770.0, 58.0],
    [0.8712, 131.0, 1180.0, 1520.0, 202.0],
    [1.98, 124.0, 1390.0, 2100.0, 409.0],
    [3.212, 114.0, 810.0, 3350.0, 660.0],
])  # fmt: skip
UNKNOWN = (
    "no card of the damper: its force is not known, a conservative envelope of the original rig's damper stands for it"
)


@dataclass(frozen=True)
class Course:
    """What a drive asks for, on its set points: time, position, speed, acceleration, force, all (n,) SI.

    ``against`` is the part of the force that brakes the table: 0 where the damper pushes it on.
    """

    t: Array
    x: Array
    v: Array
    a: Array
    force: Array
    notes: tuple[str, ...] = ()

    @property
    def speed(self) -> Array:
        """m/s, the greater one of the straight pieces before and behind each set point."""
        pieces = np.abs(np.diff(self.x)) / (self.t[1] - self.t[0])
        return np.maximum(np.append(pieces, 0.0), np.insert(pieces, 0, 0.0))

    @property
    def energy(self) -> float:
        """J that the force takes up, the integral of F dx."""
        return float(np.sum(0.5 * (self.force[1:] + self.force[:-1]) * np.diff(self.x)))

    @property
    def against(self) -> Array:
        """N, at least 0."""
        return np.maximum(self.force * np.sign(self.v), 0.0)


def specimen(rig: RigSettings, folder: Path | None = None) -> Damper | None:
    """The damper whose card the rig names, looked for in the folder ``beside``.

    Where it names none: the simulated rig's own damper, and None where wires lead to a real one.
    """
    if rig.specimen.card or not rig.wires.serial:
        return specimen_of(rig, folder)
    return None


def course(drive: Drive, rig: RigSettings, damper: Damper | None) -> Course:
    """What the drive asks for; raises :class:`~dampyr.errors.RangeError` where the damper's range does not hold its voltage."""
    x, u = _path(drive, rig)
    t = np.arange(x.size, dtype=np.float64) * drive.period
    v = np.asarray(np.gradient(x, drive.period), dtype=float)
    a = np.asarray(np.gradient(v, drive.period), dtype=float)
    if damper is None:
        return Course(t, x, v, a, np.copysign(envelope(x, v, u), v))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DampyrWarning)
        if damper.input == "V":
            force = damper.force(t, x, velocity=v, voltage=u)
        else:
            force = damper.force(t, x, velocity=v, current=u / rig.supply.resistance)
    notes = tuple(dict.fromkeys(str(each.message) for each in caught if issubclass(each.category, DampyrWarning)))
    return Course(t, x, v, a, force, notes)


def envelope(x: Array, v: Array, voltage: Array) -> Array:
    """The conservative envelope of the force [N], see above."""
    u = np.asarray(voltage, dtype=float)
    k = np.clip(np.searchsorted(FIT[:, 0], u, side="right") - 1, 0, len(FIT) - 2)
    share = ((u - FIT[k, 0]) / (FIT[k + 1, 0] - FIT[k, 0]))[..., None]
    F0, stiffness, damping, Fy = np.moveaxis(FIT[k, 1:] + share * (FIT[k + 1, 1:] - FIT[k, 1:]), -1, 0)
    return np.asarray(FACTOR * (F0 + stiffness * np.abs(x) + damping * np.abs(v) + Fy))


def _path(drive: Drive, rig: RigSettings) -> tuple[Array, Array]:
    """The planned path; for timed reversals that of an unloaded actuator from the middle."""
    timed = drive.reversals
    if timed is None:
        return drive.displacement, drive.voltage
    t, whole = np.arange(drive.n) * drive.period, timed.half_period + timed.pause
    stroke, since = np.divmod(t, whole)
    share = np.minimum(2 * np.minimum(since, whole - since) / timed.half_period, 1.0) * (stroke < timed.count)
    v = np.where(stroke % 2, -1.0, 1.0) * share * timed.duty * rig.actuator.free_speed
    return np.asarray(np.cumsum(v) * drive.period), drive.voltage
