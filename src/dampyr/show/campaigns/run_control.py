"""What the progress of a campaign and its control show."""

from __future__ import annotations

from dampyr.campaigns.run_control import Progress, RunControl
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_progress(progress: Progress) -> Description:
    """The test under way, its cycles, the time that is left, and the readings."""
    readings = f"{progress.force:.4g} N, {1e3 * progress.stroke:.4g} mm peak to peak, {progress.temperature:.4g} °C"
    return Description(
        f"Progress, {progress.done} of {progress.total} tests",
        [
            ("test", f"{progress.name}, {progress.phase}, {100 * progress.fraction:.3g} %"),
            ("cycles", f"{progress.cycles:.3g} of {progress.planned_cycles:.3g}"),
            ("time left", f"{progress.time_left:.4g} s"),
            ("now", readings),
        ],
    )


@describe.register
def describe_control(control: RunControl) -> Description:
    """Which buttons are pressed."""
    pressed = ["pause"] * control.paused + ["stop"] * control.stopped + ["abort"] * control.aborted
    return Description("RunControl", [("pressed", ", ".join(pressed) or "nothing")])
