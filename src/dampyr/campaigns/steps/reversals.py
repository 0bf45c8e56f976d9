r"""Reversals: the motor's duty rises and falls evenly, one way and the other; the original rig's excitation.

.. math:: \dot x \approx \pm v_0\, d \min\Big(\frac{2 t}{T}, 1, \frac{2 (T + p - t)}{T}\Big) \text{ in each stroke of } T + p

with the half period T, the pause p at the top and the free speed v_0. No position is followed: the stroke follows from the
force (it falls as the voltage rises) and the middle drifts. Its peaks here are those of an unloaded actuator, so that nothing
is not controlled. Use it to repeat the original campaign; else use `sine`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from dampyr.campaigns.paths import AFTER, MAX_DURATION
from dampyr.campaigns.step import Peaks, Period, Rest, Volts, check_ranges
from dampyr.errors import InputError
from dampyr.rig import Drive, RigSettings
from dampyr.rig import DutyReversals as Timed
from dampyr.units import Quantity


@dataclass(frozen=True)
class Reversals:
    """Timed reversals of the motor."""

    half_period: Annotated[float, Quantity("s", low=0.02, high=60.0), "duration of rise and fall together"]
    duty: Annotated[
        float, Quantity("", low=0.0, high=1.0, open_low=True), "duty at the top, as a part of the full voltage"
    ] = 1.0
    pause: Annotated[float, Quantity("s", low=0.0, high=5.0), "time for which the duty stays at the top"] = 0.05
    count: Annotated[int, Quantity("", low=2.0), "number of strokes, one way each"] = 20
    voltage: Annotated[float, Volts, "voltage at the coil"] = 0.0
    rest_before: Annotated[float, Rest, "rest before the motion, recorded so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "time from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("half_period", "duty", "voltage")
    named: ClassVar[tuple[str, ...]] = ("half_period", "duty", "voltage")
    fixed: ClassVar[bool] = False
    learns: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_ranges(self)

    def drive(self, rig: RigSettings) -> Drive:
        """How long it takes, the voltage, and the reversals; its set points of the table are all 0."""
        length = self.rest_before + self.count * (self.half_period + self.pause) + AFTER
        if length > MAX_DURATION:
            raise InputError(
                f"the reversals take {length / 60:.4g} min, at most {MAX_DURATION / 60:g} min are drawn; shorten them"
            )
        n = round(length / self.period) + 1
        timed = Timed(self.duty, self.half_period, self.pause, self.count)
        return Drive(self.period, np.zeros(n), np.full(n, self.voltage), reversals=timed)

    def peaks(self, rig: RigSettings) -> Peaks:
        """The way of the first stroke, from the middle, and the free speed times the duty."""
        speed = self.duty * rig.actuator.free_speed
        return Peaks(speed * (0.5 * self.half_period + self.pause), speed)
