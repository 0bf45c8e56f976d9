"""A control law beside another program's time loop: OpenSees, a virtual hybrid test."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper
from dampyr.structures.building import Building
from dampyr.structures.control_laws import lag_of, values_at
from dampyr.structures.controller import ControllerRun, design_controller
from dampyr.structures.wanted_force import inverse_of

Array = NDArray[np.float64]


class LawInput:
    """The input that a control law decides from what another time loop commits, as `dampyr.structures.respond` does.

    ``row`` (n,) turns the coordinates of ``building`` into the damper's stroke; ``motion`` is that of the ground, which a law
    of the state alone does not need. Raises :class:`~dampyr.errors.InputError` where the law cannot control the damper, or
    needs the motion.
    """

    def __init__(self, law: Any, damper: Damper, building: Building, row: Array, motion: GroundMotion | None) -> None:
        values_at(law, damper)
        self.law, self.lag = law, lag_of(law, damper)
        controller = design_controller(law, building, row[None], 0)
        self.run = ControllerRun(controller, inverse=inverse_of(law, damper))
        if np.any(controller.rows[:, 2 * building.n : 2 * building.n + 2]) and motion is None:
            raise InputError(
                "this law needs the motion of the ground, which OpenSees does not send; give the motion that shakes the "
                "structure there, --motion FILE or motion=, or choose a law of the state alone, such as clipped_optimal"
            )
        self.motion = motion
        if motion is not None:
            a, dt, self.time = motion.acceleration, motion.dt, motion.time
            self.ground = np.concatenate([[0.0], np.cumsum(0.5 * dt * (a[1:] + a[:-1]))])
        self.next, self.command, self.level, self.since = 0.0, law.low, law.low, 0.0

    def input_at(self, t: float) -> float:
        """The input at the end of a trial: the coil follows the command with its lag."""
        if self.lag == 0.0:
            return self.command
        return self.command + (self.level - self.command) * float(np.exp(-(t - self.since) / self.lag))

    def is_due(self, t: float) -> bool:
        """Whether the law's period has passed at a time."""
        return t >= self.next - 1e-9 * float(self.law.period)

    def decide_at(self, t: float, x: Array, v: Array, force: float) -> None:
        """The law's decision at a committed time, where its period has passed."""
        self.level, self.since = self.input_at(t), t
        if not self.is_due(t):
            return
        ground = [0.0, 0.0]
        if self.motion is not None:
            ground = [float(np.interp(t, self.time, of)) for of in (self.ground, self.motion.acceleration)]
        self.command = self.run.decide(np.concatenate([x, v, ground, [force]]))
        self.next += self.law.period * max(1.0, np.floor((t - self.next) / self.law.period + 1e-9) + 1.0)
