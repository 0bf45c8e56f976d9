"""Scores of many records: every record a dot, each group's mean a bar, what to beat a diamond."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

L1 = Axis("L1 ratio", "%", 100.0)


def scores(
    groups: Mapping[str, ArrayLike],
    references: Mapping[str, Mapping[str, float]] | None = None,
    axis: Axis = L1,
    title: str = "",
) -> Figure:
    """``groups`` name -> the scores of its records; ``references`` name -> group -> value."""
    with style.single_panel(0.85 + 0.24 * len(groups), title) as (fig, panel):
        for row, values in enumerate(groups.values()):
            dots = axis.of(values)
            panel.barh(row, float(np.mean(dots)), 0.55, color=style.SKY, alpha=0.35, label="mean")
            spread = row + np.linspace(-0.16, 0.16, len(dots)) if len(dots) > 1 else [row]
            panel.plot(dots, spread, "o", ms=3.5, color=style.BLUE, label="record")
        rows = {name: row for row, name in enumerate(groups)}
        for colour, (name, by_group) in zip(
            cycle((style.VERMILLION, style.GREEN, style.PURPLE)), (references or {}).items(), strict=False
        ):
            points = [(float(axis.of(value)), rows[group]) for group, value in by_group.items()]
            panel.plot(*zip(*points, strict=True), "D", ms=6, mfc="none", mew=1.4, color=colour, label=name)
        panel.set_yticks(range(len(groups)), list(groups))
        panel.invert_yaxis()
        panel.set_xlim(left=0)
        panel.grid(visible=False, axis="y")
        panel.set_xlabel(axis.label)
        style.legend(fig, panel)
    return fig
