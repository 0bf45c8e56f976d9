"""Guided calibration of the load cell: read it without load, then with a known one, check, save."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from dampyr.rig.load_cell_calibration import Calibrating

Step = Literal["unloaded", "loaded", "shunted"]


@dataclass(frozen=True)
class Guided:
    """How far it is: whether the cell was read without load and with one, the scale N/V, its noise N, and a doubt in words."""

    zeroed: bool = False
    scaled: bool = False
    zero: float | None = None
    scale: float | None = None
    noise: float | None = None
    doubt: str = ""

    def after(self, step: Step, steps: Calibrating) -> Guided:
        """The same one step on."""
        calibration, noise = steps.calibration, steps.noise
        scaled = step != "unloaded"
        return Guided(
            True,
            scaled,
            calibration.zero,
            calibration.scale,
            None if math.isnan(noise) else noise,
            steps.doubt if scaled else "",
        )
