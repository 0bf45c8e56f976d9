"""A ground motion: its acceleration over time, with the peak marked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import ACCELERATION, TIME
from dampyr.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def ground_motion(time: ArrayLike, acceleration: ArrayLike, title: str = "") -> Figure:
    """``time`` s and ``acceleration`` m/s², both ``(n,)``."""
    t, a = TIME.of(time), ACCELERATION.of(acceleration)
    peak = int(np.argmax(np.abs(a)))
    with style.single_panel(1.9, title) as (fig, panel):
        style.line(panel, t, a, color=style.BLUE, lw=0.8)
        in_g = abs(a[peak]) / STANDARD_GRAVITY
        label = f"peak {abs(a[peak]):.4g} m/s² = {in_g:.4g} g at {t[peak]:.4g} s"
        panel.plot(t[peak], a[peak], "o", ms=4, color=style.VERMILLION, ls="none", label=label)
        panel.set_xlim(t[0], t[-1])
        style.name_axes(panel, TIME, ACCELERATION)
        style.legend(fig, panel, min_entries=1)
    return fig
