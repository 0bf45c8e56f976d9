"""Preliminary check: a slow stroke before the first test verifies encoder and load cell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.campaigns.campaign_thresholds import USUAL, CampaignThresholds
from dampyr.errors import RigFault
from dampyr.rig.drive import Drive
from dampyr.rig.session import ArmedRig

Array = NDArray[np.float64]


def preliminary_check(table: ArmedRig, drive: Drive, thresholds: CampaignThresholds = USUAL) -> str:
    """The result in words; :class:`RigFault` where a test should not begin."""
    blocks = [(samples.displacement[selection], samples.force[selection]) for samples, selection in table.play(drive)]
    x, force = (np.concatenate(rows) for rows in zip(*blocks, strict=True))
    commanded, measured = float(np.ptp(drive.displacement)), float(np.ptp(x))
    if abs(measured / commanded - 1.0) > thresholds.stroke_error:
        raise RigFault(
            f"the slow stroke before the first test was {measured * 1e3:.2f} mm where {commanded * 1e3:.2f} mm were asked for; "
            "look at the encoder and the screw",
            "check",
        )
    # A force that opposes a positive velocity is positive: over the stroke and back any damper takes energy.
    energy = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))
    if energy <= 0.0:
        raise RigFault(
            f"the slow stroke before the first test gave {-energy:.3g} J instead of taking some; is the force's sign inverted, "
            "or the load cell not connected?",
            "check",
        )
    return f"stroke {measured * 1e3:.2f} mm, force {np.ptp(force):.0f} N peak to peak, {energy:.3g} J"
