"""Intervals as a plan expected them against those that the fit gave afterwards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from dampyr.show.figures import style
from dampyr.show.figures.envelope import MARKERS
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WITHIN = 0.3  # the band that is shown about what was expected
EXPECTED = Axis("expected half width", "%", 100.0)
ACHIEVED = Axis("achieved half width", "%", 100.0)


def expected_widths(pairs: Mapping[str, Sequence[tuple[float, float]]], title: str = "") -> Figure:
    """``pairs`` name -> the expected and the achieved half width of each coefficient over its value; the band is 30 %."""
    with style.single_panel(3.6, title) as (fig, panel):
        every = np.array([pair for coefficients in pairs.values() for pair in coefficients], dtype=float).reshape(-1, 2)
        low, high = (100.0 * float(every.min()) / 1.5, 100.0 * float(every.max()) * 1.5) if every.size else (0.1, 10.0)
        ends = np.array([low, high])
        panel.fill_between(
            ends, ends * (1 - WITHIN), ends * (1 + WITHIN), color=style.MUTED, alpha=0.18, lw=0, label="±30 %"
        )
        panel.plot(ends, ends, color=style.MUTED, lw=1.0)
        colours = style.case_colours(pairs)
        for marker, (name, coefficients) in zip(cycle(MARKERS), pairs.items(), strict=False):
            widths = np.array(coefficients, dtype=float)
            panel.plot(
                EXPECTED.of(widths[:, 0]),
                ACHIEVED.of(widths[:, 1]),
                marker,
                ms=7,
                mfc="none",
                mew=1.4,
                color=colours[name],
                label=name,
            )
        style.logarithmic(panel)
        panel.set_xlim(low, high)
        style.name_axes(panel, EXPECTED, ACHIEVED)
        style.legend(fig, panel, columns=4, min_entries=1)
    return fig
