"""Sines whose drive is learned, as campaigns and as set points."""

from typing import Any

from dampyr import campaigns
from dampyr.campaigns.steps.sine import Sine
from dampyr.rig import Drive, RigSettings

NAME = "01-sine-8mm-0.84Hz-3.212V"


def sine(**changes: Any) -> dict[str, Any]:
    """A step of a campaign."""
    step = {
        "kind": "sine", "amplitude": "8 mm", "frequency": "0.84 Hz", "voltage": "3.212 V", "cycles": 2, "rest_before": "0.2 s",
        "learn": True,
    }  # fmt: skip
    return step | changes


def campaign(*steps: dict[str, Any], **header: Any) -> campaigns.Campaign:
    """A campaign of these steps, without a stroke before the first of them."""
    return campaigns.campaign_of({"rest_between": "0.2 s", "check_amplitude": 0, "step": list(steps)} | header)


def swung(frequency: float, cycles: int = 12) -> Drive:
    """The drive of a sine of 10 mm with two cycles of taper on either side."""
    return Sine(0.01, frequency, cycles=cycles, taper=2).drive(RigSettings())
