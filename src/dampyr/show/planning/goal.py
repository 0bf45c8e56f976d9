"""What the peak of a structure that a plan is after shows."""

from __future__ import annotations

from dampyr.planning.goal import Peak
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_peak(peak: Peak) -> Description:
    """Which peak, and in which motion."""
    return Description(f"Peak, {peak.words}", [("motion", peak.motion.name)])
