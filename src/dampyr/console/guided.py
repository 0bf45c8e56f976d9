"""Guided calibration of the load cell: read it without load, then with a known one, check, save."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from dampyr.rig import Rig
from dampyr.rig.load_cell_calibration import Calibrating

READING = 1.0  # s of the load cell
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


class GuidedCalibration:
    """A calibration under way; ``guided`` says how far it is."""

    def __init__(self, rig: Rig) -> None:
        self._steps, self.guided = Calibrating(rig, READING), Guided()

    def read(self, step: Step, load: str) -> None:
        """Read the cell ``unloaded``; ``loaded`` with a force or a mass such as "20 kg"; ``shunted`` with a resistor."""
        steps, scaled = self._steps, step != "unloaded"
        {"unloaded": steps.zero, "loaded": lambda: steps.loaded(load), "shunted": lambda: steps.shunted(load)}[step]()
        calibration, noise = steps.calibration, None if math.isnan(steps.noise) else steps.noise
        self.guided = Guided(True, scaled, calibration.zero, calibration.scale, noise, steps.doubt if scaled else "")

    def keep(self) -> str:
        """Save the result next to the rig's file if it has one, else use it; what was saved, in words."""
        rig = self._steps.rig
        if rig.folder is not None:
            return f"saved: {self._steps.save(rig.folder).name}, next to the rig's file"
        rig.use(self._steps.calibration)
        return ""
