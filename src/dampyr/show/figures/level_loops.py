"""Loops of the levels of a test of devices: the cycles that were judged, a panel for each level."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, FORCE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS, THIRD = 3, 2  # panels in a row; the place of the third cycle


def level_loops(levels: Mapping[str, Sequence[tuple[ArrayLike, ArrayLike]]], title: str = "") -> Figure:
    """``levels`` name -> displacement m and force N of each of its cycles; the third cycle stands out."""
    columns = min(COLUMNS, len(levels))
    rows = math.ceil(len(levels) / columns)
    with style.panels(0.5 + 1.9 * rows, rows, columns, title) as (fig, axes):
        for empty in axes.flat[len(levels) :]:
            empty.set_axis_off()
        panels = list(axes.flat[: len(levels)])
        for panel, (name, cycles) in zip(panels, levels.items(), strict=True):
            for number, (x, force) in enumerate(cycles):
                third = number == THIRD
                look = (
                    {"color": style.VERMILLION, "lw": 1.3, "zorder": 3} if third else {"color": style.BLUE, "lw": 0.8}
                )
                label = "cycle 3" if third else "other cycles"
                style.line(panel, DISPLACEMENT.of(x), FORCE.of(force), label=label, **look)
            panel.set_title(name, loc="left", fontsize=7.5)
        fig.supxlabel(DISPLACEMENT.label, fontsize=10)
        for panel in axes[:, 0]:
            panel.set_ylabel(FORCE.label)
        style.legend(fig, *panels)
    return fig
