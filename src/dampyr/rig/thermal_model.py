"""Temperature of the damper: heat generated less heat lost to the room, beside a thermocouple's reading where one is wired.

A thermocouple that fell off, or whose amplifier is dead, reads a cool damper for ever. So the estimate is kept beside the
reading and never replaced by it: the guard takes the hotter of the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dampyr.rig.interlock import Samples
from dampyr.rig.settings import RigSettings

COPPER, COLD = 0.0039, 20.0  # 1/K, degC: the coil's resistance is that of the settings when cold
THERMOCOUPLE = 1.0  # K, standard uncertainty of the amplifier and the junction; assumed
PARTED = 10.0  # K between reading and estimate from which one of them is wrong: 3.9 % of the coil's resistance
"""Also what the estimate may change while the reading stands, before the thermocouple is taken for dead: heat_capacity
times this is the energy that went in, 4.5 kJ for the original damper. The heat capacity is assumed, to a third perhaps, and
heat takes some 8 s through a wall of 10 mm: the reading of a live one moves by far more than its own `THERMOCOUPLE` meanwhile.
What is lost to the room does not count: a damper that is as warm as it gets takes energy for hours, and its reading stands.
"""
WarmthState = tuple[float, float | None, tuple[float, float]]
"""Estimate and reading [degC], and both when the reading last moved."""


@dataclass
class Warmth:
    r"""The damper's temperature [degC]: ``estimate`` by the heat that went in, and the thermocouple's last ``reading``, if any.

    .. math:: C \dot T = F \dot x + u^2 / R - h (T - T_r)

    with the heat capacity C, the coil's resistance R and the cooling h of ``specimen`` and ``supply`` in the rig's settings.
    """

    rig: RigSettings
    estimate: float
    reading: float | None = None
    _moved: tuple[float, float] = (math.nan, math.nan)
    """The reading that the thermocouple last moved to, and the estimate at that moment."""
    _last: float = math.nan

    @property
    def temperature(self) -> float:
        """The damper's temperature [degC] as it is known best: as read, or as estimated without a live thermocouple.

        Setting it sets the estimate and forgets the reading: another damper, or one of which something else is known.
        """
        return self.estimate if self.reading is None or self.dead else self.reading

    @temperature.setter
    def temperature(self, value: float) -> None:
        self.estimate, self.reading = value, None

    @property
    def hottest(self) -> float:
        """The hotter of estimate and reading [degC], which the guard goes by."""
        return self.estimate if self.reading is None else max(self.estimate, self.reading)

    @property
    def dead(self) -> bool:
        """Whether the reading stands while the heat that went in, or was lost, changes the estimate by `PARTED`."""
        return self.reading is not None and abs(self.estimate - self._moved[1]) > PARTED

    @property
    def parted(self) -> float:
        """K by which the reading is above the estimate; 0 where nothing is read."""
        return 0.0 if self.reading is None else self.reading - self.estimate

    @property
    def doubt(self) -> str:
        """What is wrong with the thermocouple, in words; empty where nothing is."""
        if self.reading is None or not (self.dead or abs(self.parted) > PARTED):
            return ""
        readings = (
            f"the thermocouple reads {self.reading:.0f} degC, and the damper is at {self.estimate:.0f} degC by the heat that "
            "it took and lost"
        )
        if self.dead:
            heat = self.rig.specimen.heat_capacity * abs(self.estimate - self._moved[1]) / 1e3
            way = "went in" if self.estimate > self._moved[1] else "were lost"
            return (
                f"{readings}: the reading has not moved while {heat:.2g} kJ {way}, so the estimate is used; look at the "
                "thermocouple, its amplifier and its wires"
            )
        return (
            f"{readings}, {abs(self.parted):.0f} K apart, {PARTED:g} K at most: look at the thermocouple, or at "
            "specimen.heat_capacity, cooling and room; the guard takes the hotter"
        )

    @property
    def state(self) -> WarmthState:
        """What it knows, for another process."""
        return self.estimate, self.reading, self._moved

    @state.setter
    def state(self, state: WarmthState) -> None:
        self.estimate, self.reading, self._moved = state

    @property
    def resistance(self) -> float:
        """Of the coil, over that of the cold one."""
        return 1.0 + COPPER * (self.temperature - COLD)

    def take(self, samples: Samples) -> float:
        """The temperature after a block."""
        damper, dt = self.rig.specimen, 1.0 / self.rig.board.rate
        path = np.diff(samples.displacement, prepend=samples.displacement[0] if math.isnan(self._last) else self._last)
        self._last = float(samples.displacement[-1])
        heat = float(samples.force @ path) + float(np.sum(samples.voltage**2)) / self.rig.supply.resistance * dt
        self.estimate += heat / damper.heat_capacity
        self.cool(samples.n * dt)
        if samples.temperature is not None:
            self._read(float(np.mean(samples.temperature)))
        return self.temperature

    def _read(self, reading: float) -> None:
        """Take a reading of the thermocouple [degC]."""
        if self.reading is None:  # a damper that is warm already: the estimate begins with what is read, if that can be
            self.estimate = max(self.estimate, min(reading, self.rig.limits.temperature))
        if self.reading is None or abs(reading - self._moved[0]) > THERMOCOUPLE:
            self._moved = reading, self.estimate
        self.reading = reading

    def shift(self, jump: float) -> None:
        """Account for a new origin of the displacement: it grew by ``jump`` [m] and the table did not move."""
        self._last += jump

    def restart(self) -> None:
        """Start anew: the next block does not continue the last."""
        self._last = math.nan

    def cool(self, seconds: float) -> None:
        """Cool for a time."""
        damper = self.rig.specimen
        decay = math.exp(-damper.cooling / damper.heat_capacity * seconds)
        self.estimate = damper.room + (self.estimate - damper.room) * decay
