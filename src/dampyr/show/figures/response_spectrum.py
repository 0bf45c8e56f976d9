"""A response spectrum: the peaks of oscillators over their period, one line for each damping."""

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

PERIOD = Axis("period", "s")
PSEUDO_ACCELERATION = Axis("pseudo-acceleration", "m/s²")
SPECTRAL_DISPLACEMENT = Axis("displacement", "mm", 1e3)
# s: 1, 2 and 5 of each decade, as spectra are printed
TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)


def response_spectrum(
    periods: ArrayLike,
    cases: Mapping[str, ArrayLike],
    axis: Axis = PSEUDO_ACCELERATION,
    title: str = "",
    height: float = 3.1,
) -> Figure:
    """``periods`` s ``(p,)``, greater than 0; ``cases`` name -> SI ``(p,)``, each told with its peak; ``height`` in inches."""
    T = PERIOD.of(periods)
    with style.single_panel(height, title) as (fig, panel):
        for colour, (name, values) in zip(cycle(style.SERIES), cases.items(), strict=False):
            y = axis.of(values)
            peak = int(np.argmax(y))
            panel.plot(T, y, color=colour, lw=1.2, label=f"{name}: {y[peak]:.3g} {axis.unit} at {T[peak]:.3g} s")
        panel.set_xscale("log")
        panel.set_xlim(T[0], T[-1])
        panel.set_ylim(bottom=0.0)
        shown = [tick for tick in TICKS if T[0] <= tick <= T[-1]]
        panel.set_xticks(shown, [f"{tick:g}" for tick in shown])
        panel.set_xticks([], minor=True)
        style.name_axes(panel, PERIOD, axis)
        style.legend(fig, panel, columns=2, min_entries=1)
    return fig
