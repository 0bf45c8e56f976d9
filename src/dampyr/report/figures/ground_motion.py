"""A ground motion: its acceleration over time, with the peak marked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.report import style
from dampyr.report.style import ACCELERATION, TIME

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STANDARD_GRAVITY = 9.80665


def ground_motion(time: ArrayLike, acceleration: ArrayLike, title: str = "") -> Figure:
    """``time`` s and ``acceleration`` m/s², both ``(n,)``."""
    fig, axes = style.figure(2.5, 1, 1, title)
    panel = axes[0, 0]
    t, a = TIME.of(time), ACCELERATION.of(acceleration)
    peak = int(np.argmax(np.abs(a)))
    with style.style():
        style.line(panel, t, a, color=style.BLUE, lw=0.8)
        panel.plot(t[peak], a[peak], "o", ms=4, color=style.VERMILLION)
        words = f"{abs(a[peak]):.3g} m/s² = {abs(a[peak]) / STANDARD_GRAVITY:.3g} g at {t[peak]:.3g} s"
        panel.annotate(words, (t[peak], a[peak]), (8, 0), textcoords="offset points", va="center", fontsize=9)
        panel.set_xlim(t[0], t[-1])
        style.name_axes(panel, TIME, ACCELERATION)
    return fig
