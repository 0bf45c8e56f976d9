"""Estimates of several specimens, a panel a number: each with its interval, the mean, and where a new one lies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Estimates:
    """One number of several specimens, SI: ``values`` with half intervals ``bars``, ``shrunken`` ones, and two intervals."""

    axis: Axis
    values: Mapping[str, float]
    bars: Mapping[str, float]
    shrunken: Mapping[str, float]
    mean: tuple[float, float]
    new: tuple[float, float]


def specimen_estimates(panels: Sequence[Estimates], title: str = "") -> Figure:
    """One panel per number, a row per specimen."""
    columns = min(2, len(panels))
    rows = math.ceil(len(panels) / columns)
    rows_of_panel = max(len(one.values) for one in panels)
    fig, axes = style.figure(0.4 + rows * (0.75 + 0.17 * rows_of_panel), rows, columns, title)
    with style.style():
        for k, (panel, one) in enumerate(zip(axes.flat, panels, strict=False)):
            places = np.arange(len(one.values))
            values, bars = (one.axis.of(list(each.values())) for each in (one.values, one.bars))
            panel.axvspan(*one.axis.of(one.new), color=style.SKY, alpha=0.16, lw=0, label="new specimen")
            panel.axvspan(*one.axis.of(one.mean), color=style.ORANGE, alpha=0.3, lw=0, label="mean")
            style_of_bars = {"fmt": "o", "ms": 3.5, "color": style.BLUE, "capsize": 2.0, "lw": 1.0}
            panel.errorbar(values, places, xerr=bars, label="estimate", **style_of_bars)
            shrunken = one.axis.of([one.shrunken[name] for name in one.values])
            panel.plot(shrunken, places, "x", ms=5, color=style.VERMILLION, label="drawn to the mean")
            panel.set_yticks(places, list(one.values) if k % columns == 0 or len(panels) == 1 else [""] * len(places))
            panel.set_ylim(len(places) - 0.5, -0.5)
            panel.set_xlabel(one.axis.label)
        for empty in list(axes.flat)[len(panels) :]:
            empty.set_axis_off()
        style.legend(fig, *axes.flat, columns=4)
    return fig
