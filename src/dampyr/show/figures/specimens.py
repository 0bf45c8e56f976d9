"""Estimates of several specimens, a panel a number: each with its interval, the mean, and where a new one lies."""

from __future__ import annotations

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
    rows_of_panel = max(len(number.values) for number in panels)
    with style.panel_grid(len(panels), 0.4, 0.75 + 0.17 * rows_of_panel, title) as (fig, axes, columns):
        for k, (panel, number) in enumerate(zip(axes, panels, strict=True)):
            places, axis = np.arange(len(number.values)), number.axis
            values, bars = axis.of(list(number.values.values())), axis.of(list(number.bars.values()))
            panel.axvspan(*axis.of(number.new), color=style.SKY, alpha=0.16, lw=0, label="new specimen")
            panel.axvspan(*axis.of(number.mean), color=style.ORANGE, alpha=0.3, lw=0, label="mean")
            style_of_bars = {"fmt": "o", "ms": 3.5, "color": style.BLUE, "capsize": 2.0, "lw": 1.0}
            panel.errorbar(values, places, xerr=bars, label="estimate", **style_of_bars)
            shrunken = axis.of([number.shrunken[name] for name in number.values])
            panel.plot(shrunken, places, "x", ms=5, color=style.VERMILLION, label="drawn to the mean")
            panel.set_yticks(places, list(number.values) if k % columns == 0 else [""] * len(places))
            panel.set_ylim(len(places) - 0.5, -0.5)
            panel.set_xlabel(axis.label)
        style.legend(fig, *axes, columns=4)
    return fig
