"""Progress of a test while it runs: cycles, stroke, time left."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dampyr.campaigns.planned_tests import Plan, PlannedTest
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
    planned: float = field(init=False)

    def __post_init__(self) -> None:
        self.planned = crossings(self.test.drive.displacement)

    def take(self, samples: Samples) -> None:
        """Count the crossings of the middle, with a hysteresis of a fifth of the amplitude."""
        count = max(8, round(SEEN * self.rate))
        self._past = np.concatenate([self._past, samples.displacement])[-count:]
        sides = _sides(samples.displacement, 0.2 * self.test.peak_position)
        if sides.size:
            before = self._side or sides[0]
            self.cycles += 0.5 * float(np.count_nonzero(np.diff(sides, prepend=before)))
            self._side = int(sides[-1])

    @property
    def stroke(self) -> float:
        """Peak to peak, m."""
        return float(np.ptp(self._past)) if self._past.size else 0.0


def time_left(plan: Plan, remaining: int, within: float = 0.0) -> float:
    """s of rig time that are left when ``remaining`` tests are still to run, ``within`` s of the first of them gone."""
    if not remaining:
        return 0.0
    rests = plan.campaign.header.rest_between * (remaining - 1)
    return sum(map(plan.rig_time, plan.tests[-remaining:])) + rests - within


def crossings(x: Array, fraction: float = 0.2) -> float:
    """Cycles of a planned path."""
    return 0.5 * float(np.count_nonzero(np.diff(_sides(x, fraction * float(np.abs(x).max(initial=0.0))))))


def _sides(x: Array, threshold: float) -> NDArray[np.int8]:
    """1 and -1 where the path is beyond the threshold, the rest left out."""
    sides = (x > threshold).astype(np.int8) - (x < -threshold).astype(np.int8)
    return sides[sides != 0]
