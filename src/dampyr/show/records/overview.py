"""What the overview of a motion shows."""

from __future__ import annotations

from dampyr.records.checks.overview import Overview
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_overview(overview: Overview) -> Description:
    """Whether the motion repeats itself, its stroke, speeds and dominant frequency, and the work of the force."""
    dominant = "none: it does not move" if overview.dominant_hz is None else f"{overview.dominant_hz:.4g} Hz"
    return Description(
        "Overview",
        [
            ("motion", "repeats itself" if overview.repeats else "does not repeat itself"),
            ("stroke", f"{1e3 * overview.stroke_m:.4g} mm"),
            ("speed", f"peak {1e3 * overview.peak_speed:.4g} mm/s, rms {1e3 * overview.rms_speed:.4g} mm/s"),
            ("dominant", dominant),
            ("work", f"{overview.work:.4g} J"),
        ],
    )
