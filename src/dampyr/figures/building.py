"""How a building answers: one quantity of several cases over one another, each with its peak marked."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.figures import style
from dampyr.figures.style import DISPLACEMENT, TIME, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def building_response(
    time: ArrayLike,
    cases: Mapping[str, ArrayLike],
    axis: Axis = DISPLACEMENT,
    title: str = "",
) -> Figure:
    """``time`` s ``(n,)``; ``cases`` name -> SI ``(n,)``; the first is drawn grey, as what to compare with.

    Each name is followed by the greatest magnitude among the samples shown.
    """
    fig, axes = style.figure(3.3, 1, 1, title)
    panel = axes[0, 0]
    colours = (style.MUTED, style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE, style.ORANGE)
    t = TIME.of(time)
    with style.style():
        for colour, (name, values) in zip(cycle(colours), cases.items(), strict=False):
            y = axis.of(values)
            peak = int(np.argmax(np.abs(y)))
            label = f"{name}: {abs(y[peak]):.3g} {axis.unit}"
            style.line(panel, t, y, color=colour, lw=1.1, label=label)
            panel.plot(t[peak], y[peak], "o", ms=4, color=colour)
        panel.set_xlim(t[0], t[-1])
        style.name_axes(panel, TIME, axis)
        style.legend(fig, panel, columns=2, min_entries=1)
    return fig
