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
    from matplotlib.ticker import LogLocator, NullFormatter

    fig, axes = style.figure(3.6, 1, 1, title)
    panel = axes[0, 0]
    with style.style():
        every = np.array([pair for some in pairs.values() for pair in some], dtype=float).reshape(-1, 2)
        low, high = (100.0 * float(every.min()) / 1.5, 100.0 * float(every.max()) * 1.5) if every.size else (0.1, 10.0)
        ends = np.array([low, high])
        panel.fill_between(
            ends, ends * (1 - WITHIN), ends * (1 + WITHIN), color=style.MUTED, alpha=0.18, lw=0, label="±30 %"
        )
        panel.plot(ends, ends, color=style.MUTED, lw=1.0)
        colours = style.case_colours(pairs)
        for marker, (name, some) in zip(cycle(MARKERS), pairs.items(), strict=False):
            at = np.array(some, dtype=float)
            panel.plot(
                EXPECTED.of(at[:, 0]),
                ACHIEVED.of(at[:, 1]),
                marker,
                ms=7,
                mfc="none",
                mew=1.4,
                color=colours[name],
                label=name,
            )
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_xlim(low, high)
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
        style.name_axes(panel, EXPECTED, ACHIEVED)
        style.legend(fig, panel, columns=4, min_entries=1)
    return fig
