"""What a motion that was cut into cycles shows."""

from __future__ import annotations

from dampyr.records.cycle_analysis.cycles import Cut
from dampyr.show.descriptions import Description, describe

SHOWN = 5  # levels in a text


@describe.register
def describe_cut(cut: Cut) -> Description:
    """How many cycles were run, and the first levels with their strokes and frequencies."""
    rows = [
        ("cycles", f"{cut.run:g} run, {len(cut.cycles)} whole{'' if cut.from_start else ', from the first pass on'}")
    ]
    rows += [
        (f"level {level.number}", f"{level.count} x {1e3 * level.stroke_m:.4g} mm at {1.0 / level.period_s:.4g} Hz")
        for level in cut.levels[:SHOWN]
    ]
    if len(cut.levels) > SHOWN:
        rows.append(("", f"and {len(cut.levels) - SHOWN} more levels"))
    return Description("Cut", rows)
