"""Thermal model of the damper, where nothing measures its temperature: heat generated less heat lost to the room."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dampyr.rig.interlock import Samples
from dampyr.rig.settings import RigSettings

COPPER, COLD = 0.0039, 20.0  # 1/K, degC: the coil's resistance is that of the settings when cold


@dataclass
class Warmth:
    r"""An estimate of the damper's temperature [degC].

    .. math:: C \dot T = F \dot x + u^2 / R - h (T - T_r)

    with the heat capacity C, the coil's resistance R and the cooling h of ``specimen`` and ``supply`` in the rig's settings.
    """

    rig: RigSettings
    temperature: float
    _last: float = math.nan

    @property
    def resistance(self) -> float:
        """Of the coil, over that of the cold one."""
        return 1.0 + COPPER * (self.temperature - COLD)

    def take(self, samples: Samples) -> float:
        """The temperature after a block."""
        body, dt = self.rig.specimen, 1.0 / self.rig.board.rate
        path = np.diff(samples.displacement, prepend=samples.displacement[0] if math.isnan(self._last) else self._last)
        self._last = float(samples.displacement[-1])
        heat = float(samples.force @ path) + float(np.sum(samples.voltage**2)) / self.rig.supply.resistance * dt
        self.temperature += heat / body.heat_capacity
        self.cool(samples.n * dt)
        if samples.temperature is not None:  # measured: the estimate is for where nothing is
            self.temperature = float(samples.temperature[-1])
        return self.temperature

    def shift(self, jump: float) -> None:
        """Account for a new origin of the displacement: it grew by ``jump`` [m] and the table did not move."""
        self._last += jump

    def restart(self) -> None:
        """Start anew: the next block does not continue the last."""
        self._last = math.nan

    def cool(self, seconds: float) -> None:
        """Cool for a time."""
        body = self.rig.specimen
        self.temperature = body.room + (self.temperature - body.room) * math.exp(
            -body.cooling / body.heat_capacity * seconds
        )
