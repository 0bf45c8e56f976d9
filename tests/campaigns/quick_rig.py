"""The simulated rig read in long blocks: a campaign costs the host a third of the work, and records what it did.

A proof reads the rig as it ships: the block is the interlocks' reaction.
"""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.rig import Rig, RigSettings, simulated

QUICK = replace(
    RigSettings(),
    board=replace(RigSettings().board, block=0.1),
    limits=replace(RigSettings().limits, heartbeat=0.2),  # two blocks
)

SHORT = """
rest_between = "0.5 s"
check_amplitude = "0 mm"
[[step]]
kind = "sine"
amplitude = "5 mm"
frequency = "1 Hz"
voltage = {voltage}
cycles = 6
rest_before = "1 s"
"""

TWO_SINES = """
name = "short"
rest_between = "0.1 s"
check_amplitude = "0 mm"
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "1 Hz"
voltage = ["0 V", "1 V"]
cycles = 1
rest_before = "0.2 s"
"""
FIRST, SECOND = "01-sine-4mm-1Hz-0V", "02-sine-4mm-1Hz-1V"

QUAKE = (
    TWO_SINES.split("[[step]]")[0]
    + '[[step]]\nkind = "earthquake"\nmotion = "motion.csv"\nscale = 0.02\nrest_before = "0.2 s"\n'
)


def motion(path: Path, size: float) -> None:
    """A ground motion of one second, ``size`` in m/s²."""
    t = np.arange(0.0, 1.0, 0.02)
    rows = "".join(f"{at:.2f},{size * np.sin(4 * np.pi * at):.6f}\n" for at in t)
    path.write_text(f"time [s],acceleration [m/s^2]\n{rows}")


TWO = """
name = "two"
operator = "A. Person"
note = "a note"
rest_between = "0.5 s"
[[step]]
kind = "sine"
amplitude = "5 mm"
frequency = "1 Hz"
voltage = ["0 V", "1.5 V"]
cycles = 2
rest_before = "0.5 s"
"""

proving = False  # whether the test that runs is a proof; conftest.py sets it


def usual_settings() -> RigSettings:
    """Those of a quick rig, and in a proof those that ship."""
    return RigSettings() if proving else QUICK


def quick_rig(*faults: str, settings: RigSettings | str | os.PathLike[str] | None = None, **options: Any) -> Rig:
    """A simulated rig with these faults, such as ``stalled-motor@7s``."""
    return simulated(settings or usual_settings(), faults=faults, **options)
