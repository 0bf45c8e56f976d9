"""What is told of a test while it runs: cycles, stroke, time left."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dampyr.campaigns.plan import Plan, PlannedTest
from dampyr.rig.interlock import Samples

Array = NDArray[np.float64]
SEEN = 1.0  # s of the past that the stroke is taken from


@dataclass
class Watch:
    """Follows one test."""

    test: PlannedTest
    rate: float
    cycles: float = 0.0
    _past: Array = field(default_factory=lambda: np.empty(0))
    _side: int = 0

    def take(self, samples: Samples) -> None:
        """Count the crossings of the middle, with a hysteresis of a fifth of the amplitude."""
        keep = max(8, round(SEEN * self.rate))
        self._past = np.concatenate([self._past, samples.displacement])[-keep:]
        threshold = 0.2 * self.test.peak_position
        for x in samples.displacement:
            side = 1 if x > threshold else -1 if x < -threshold else self._side
            self.cycles += 0.5 * (side != self._side and self._side != 0)
            self._side = side

    @property
    def stroke(self) -> float:
        """Peak to peak, m."""
        return float(np.ptp(self._past)) if self._past.size else 0.0


def time_left(plan: Plan, remaining: int, within: float = 0.0) -> float:
    """s of rig time that are left when ``remaining`` tests are still to run, ``within`` s of the first of them gone."""
    if not remaining:
        return 0.0
    rests = plan.campaign.header.rest_between * (remaining - 1)
    return sum(test.duration for test in plan.tests[-remaining:]) + rests - within


def crossings(x: Array, fraction: float = 0.2) -> float:
    """Cycles of a planned path."""
    threshold = fraction * float(np.abs(x).max(initial=0.0))
    sides = np.sign(np.where(np.abs(x) > threshold, x, 0.0))
    sides = sides[sides != 0.0]
    return 0.5 * float(np.count_nonzero(np.diff(sides)))
