"""Imports and compilation of a campaign, done before a rig is armed: a thread that imports would delay the one that reads."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

from dampyr.campaigns import campaign_of, perform
from dampyr.rig import simulated

SHORT = {
    "check_amplitude": "1 mm",
    "step": [{"kind": "sine", "amplitude": "1 mm", "frequency": "5 Hz", "cycles": 1, "rest_before": "0.1 s"}],
}


@cache
def warm_up() -> None:
    """Run a campaign of a second on a rig simulated in this process, once."""
    with tempfile.TemporaryDirectory(prefix="dampyr-") as folder, simulated() as rig:
        perform(campaign_of(SHORT), rig, Path(folder) / "warm")
