"""Parameters against the input: points with error bars, the law's curve, the calibrated range shaded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.descriptions import Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.style import VOLTAGE, Axis
from dampyr.show.figures.symbols import as_mathtext
from dampyr.shown import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class LawPanel(Shown):
    """One parameter over the input, for one panel.

    ``axis`` names it and its unit; ``curve`` (inputs, values) is the law; ``points`` (inputs, values) are
    what it was made from or is compared with, ``error`` their half error bars; ``others`` name -> (inputs,
    values) are further points, such as published ones. All SI.
    """

    axis: Axis
    curve: tuple[ArrayLike, ArrayLike] | None = None
    points: tuple[ArrayLike, ArrayLike] | None = None
    error: ArrayLike | None = None
    others: Mapping[str, tuple[ArrayLike, ArrayLike]] = field(default_factory=dict)


@describe.register
def describe_law(law: LawPanel) -> Description:
    """How many inputs the curve and the points have; the law by itself."""
    rows = [("curve", law.curve), ("points", law.points), *law.others.items()]
    shown = [(name, f"{np.size(points[0])} inputs") for name, points in rows if points is not None]
    return Description(f"LawPanel {law.axis.label!r}", shown, figure=lambda: parameters_against_input([law]))


def parameters_against_input(
    laws: Sequence[LawPanel],
    calibrated: tuple[float, float] | None = None,
    axis: Axis = VOLTAGE,
    title: str = "",
) -> Figure:
    """One panel per parameter; ``calibrated`` is the range of the input that the laws were fitted on."""
    with style.panel_grid(len(laws), 0.5, 1.6, title, most=3, sharex=True) as (fig, panels, columns):
        for panel, law in zip(panels, laws, strict=True):
            if calibrated:
                low, high = axis.of(calibrated)
                panel.axvspan(low, high, color=style.SKY, alpha=0.16, lw=0, label="calibrated range")
            if law.curve:
                style.line(panel, axis.of(law.curve[0]), law.axis.of(law.curve[1]), color=style.BLUE, label="law")
            if law.points:
                bars = None if law.error is None else law.axis.of(law.error)
                if bars is not None:  # infinite ones (the data say nothing) cannot be drawn; the table beside says so
                    bars = np.where(np.isfinite(bars), bars, np.nan)
                x, y = axis.of(law.points[0]), law.axis.of(law.points[1])
                panel.errorbar(x, y, bars, fmt="o", ms=4, color=style.VERMILLION, capsize=2.5, lw=1, label="fitted")
            for colour, (name, (inputs, values)) in zip(cycle(style.SERIES[2:]), law.others.items(), strict=False):
                panel.plot(axis.of(inputs), law.axis.of(values), "D", ms=4, mfc="none", color=colour, label=name)
            panel.set_ylabel(f"{as_mathtext(law.axis.words)} [{law.axis.unit}]")
        for panel in panels[-columns:]:
            panel.set_xlabel(axis.label)
            panel.tick_params(labelbottom=True)
        style.legend(fig, *panels, columns=4)
    return fig
