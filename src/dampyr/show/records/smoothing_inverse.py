"""What a moving average that was undone shows."""

from __future__ import annotations

from dampyr.phrases import extent
from dampyr.records.conditioning.smoothing_inverse import Undone
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_undone(undone: Undone) -> Description:
    """Extent of the raw values, where the first come from, their noise and their error."""
    sure = "" if undone.reliable else ", more than the noise: not to be used"
    rows = [
        ("values", f"{extent(undone.values, '')}, {undone.values.size} samples, in the channel's unit"),
        ("start", f"{undone.start}; {undone.missing:.3g} rms is missing"),
        ("noise", f"{undone.noise:.3g}"),
        (
            "error",
            f"{undone.error:.3g}{sure}; errors of the smoothed values are multiplied by up to {undone.growth:.3g}",
        ),
    ]
    if undone.grid is not None:
        rows.append(("grid", f"rounded to steps of {undone.grid:.4g}"))
    return Description("Undone moving average", rows)
