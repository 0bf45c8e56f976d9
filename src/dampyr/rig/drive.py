"""Drive of one test: set points of the table and of the coil."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.shown import Shown
from dampyr.units import Quantity

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DutyReversals:
    """The original rig's excitation: a duty that rises and falls evenly, one way and the other; no position is followed.

    ``duty`` at the top, 0 to 1; ``half_period`` s of rise and fall together; ``pause`` s at the top; ``count``
    strokes, one way each. The original ran tops of 165 to 248 of 255, 2.2 or 4.2 ms for each step of the duty, pause 0.05 s.
    """

    duty: Annotated[float, Quantity("", low=0.0, high=1.0, open_low=True)]
    half_period: Annotated[float, Quantity("s", low=0.02, high=60.0)]
    pause: Annotated[float, Quantity("s", low=0.0, high=5.0)] = 0.05
    count: int = 20


@dataclass(frozen=True, eq=False, repr=False)
class Drive(Shown):
    """Set points at a constant ``period`` [s]: the table's position, and the voltage at the coil.

    Parameters
    ----------
    period : s, a whole number of milliseconds.
    displacement : (n,) m from the middle of the stroke, extension positive. It begins and ends where the table rests.
    voltage : (n,) V at the coil, held between set points.
    record_from, record_to : set points between which samples are kept; ``record_to`` None is the end.
    reversals : where given, the table is driven by timed reversals; ``displacement`` then only says how long it takes.
    standing : the table is not driven at all, so that it need not be homed; the coil's voltage is.
    """

    period: float
    displacement: Array
    voltage: Array
    record_from: int = 0
    record_to: int | None = None
    reversals: DutyReversals | None = None
    until_temperature: float | None = None
    standing: bool = False

    def __post_init__(self) -> None:
        for name in ("displacement", "voltage"):
            values = np.ascontiguousarray(getattr(self, name), dtype=float)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.displacement.ndim != 1 or self.displacement.shape != self.voltage.shape or self.displacement.size < 2:
            raise InputError("displacement and voltage must be two rows of the same length, at least 2")
        if not (np.all(np.isfinite(self.displacement)) and np.all(np.isfinite(self.voltage))):
            raise InputError("displacement and voltage must be finite")
        if self.voltage.min() < 0.0:
            raise InputError(f"voltage = {self.voltage.min():g} V is negative; a damper's supply gives 0 V or more")
        steps = round(self.period * 1000)
        if not 1 <= steps <= 1000 or abs(self.period * 1000 - steps) > 1e-9:
            raise InputError(f"period = {self.period:g} s must be a whole number of milliseconds from 1 to 1000")

    @property
    def law(self) -> str:
        """The control law that sets the coil's voltage as the drive is played, in words; empty where ``voltage`` does."""
        return ""

    @property
    def voltage_range(self) -> tuple[float, float]:
        """The least and the greatest voltage [V] that it may ask for."""
        return float(self.voltage.min()), float(self.voltage.max())

    @property
    def time(self) -> Array:
        """Of the set points (n,) [s]."""
        return np.arange(self.n, dtype=np.float64) * self.period

    @property
    def n(self) -> int:
        """The number of set points."""
        return int(self.displacement.size)

    @property
    def duration(self) -> float:
        """s."""
        return (self.n - 1) * self.period
