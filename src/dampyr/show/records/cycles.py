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
        (f"level {each.number}", f"{each.count} x {1e3 * each.stroke_m:.4g} mm at {1.0 / each.period_s:.4g} Hz")
        for each in cut.levels[:SHOWN]
    ]
    if len(cut.levels) > SHOWN:
        rows.append(("", f"and {len(cut.levels) - SHOWN} more levels"))
    return Description("Cut", rows)
