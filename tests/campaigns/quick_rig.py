"""The simulated rig read in long blocks: a campaign costs the host a third of the work, and records what it did."""

from dataclasses import replace
from typing import Any

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


def quick_rig(*faults: str, settings: RigSettings = QUICK, **options: Any) -> Rig:
    """A simulated rig with these faults, such as ``stalled-motor@7s``."""
    return simulated(settings, faults=faults, **options)
