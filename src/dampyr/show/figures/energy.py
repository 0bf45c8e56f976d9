"""Energies over time: where the energy of an earthquake goes, stacked up to what it put in."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import TIME, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENERGY = Axis("energy", "J")


def energy_over_time(time: ArrayLike, shares: Mapping[str, ArrayLike], total: ArrayLike, title: str = "") -> Figure:
    """``time`` s ``(n,)``; ``shares`` name -> J ``(n,)``, stacked in their order; ``total`` J ``(n,)`` as a line."""
    t = TIME.of(time)
    colours = (style.BLUE, style.VERMILLION, style.SKY, style.ORANGE, style.GREEN, style.PURPLE)
    below = np.zeros(len(t))
    with style.single_panel(3.0, title) as (fig, panel):
        for colour, (name, values) in zip(cycle(colours), shares.items(), strict=False):
            above = below + ENERGY.of(values)
            x, low = style.thin(t, below)
            panel.fill_between(x, low, np.interp(x, t, above), color=colour, alpha=0.55, lw=0, label=name)
            below = above
        style.line(panel, t, ENERGY.of(total), color=style.INK, lw=1.1, label="input")
        panel.set_xlim(t[0], t[-1])
        panel.set_ylim(bottom=0.0)
        style.name_axes(panel, TIME, ENERGY)
        style.legend(fig, panel)
    return fig
