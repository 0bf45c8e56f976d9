"""Section on the range that a damper was calibrated on."""

from __future__ import annotations

import numpy as np

from dampyr.identification import Fit
from dampyr.input_kinds import INPUTS, group_name
from dampyr.models import Damper
from dampyr.show.figures.calibration_range import calibrated
from dampyr.show.figures.style import case_colours
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.table import Cell, Table

SHOWN = {
    "displacement": ("displacement from the middle", "mm", 1e3),
    "velocity": ("velocity", "mm/s", 1e3),
    "frequency": ("frequency", "Hz", 1.0),
}


def range_section(fit: Fit) -> Section:
    """The calibrated ranges, and amplitude against frequency of the records that made them."""
    residuals = fit.residuals
    groups = {}
    for group in residuals.groups:
        members = [r for r in residuals.records if r.name in group.records]
        name = group_name(group.input_value, residuals.unit)
        groups[name] = ([r.frequency for r in members], [0.5 * r.stroke for r in members])
    blocks: list[Block] = []
    if fit.damper is None:
        blocks.append(Text(f"There is no damper, so there is no calibrated range: {fit.reason}."))
    else:
        blocks.append(range_table(fit.damper))
    if any(np.any(np.isfinite(frequencies)) for frequencies, _ in groups.values()):
        caption = (
            "Every record by the frequency and the amplitude (half of peak to peak, per cycle) that were measured. Inside the "
            "box, between the records, the damper interpolates; beyond it, and above the dashed line, it extrapolates."
        )
        blocks.append(
            FigureBlock(
                calibrated(groups, fit.damper.ranges if fit.damper else None, colours=case_colours(groups)), caption
            )
        )
    else:
        blocks.append(Text("No record holds a whole cycle, so none has a frequency."))
    return Section("Calibrated range", blocks)


def range_table(damper: Damper) -> Table:
    """The ranges of the card, in the units people read."""
    rows: list[list[Cell]] = []
    if damper.has_input:
        rows = [[INPUTS[damper.input], *damper.range, damper.input, "refused unless allowed by name"]]
    for name, (low, high) in damper.ranges.items():
        words, unit, factor = SHOWN.get(name, (name, "SI", 1.0))
        rows.append([words, low * factor, high * factor, unit, "no warning" if name == "frequency" else "one warning"])
    return Table(
        ("quantity", "from", "to", "unit", "outside it"),
        rows,
        caption="The range covered by the records, for which the card is valid.",
        digits=4,
    )
