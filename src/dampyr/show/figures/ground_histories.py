"""A ground motion over time: acceleration, velocity and displacement, each with its peak marked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import ACCELERATION, DISPLACEMENT, TIME, VELOCITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def ground_histories(
    time: ArrayLike, acceleration: ArrayLike, velocity: ArrayLike, displacement: ArrayLike, title: str = ""
) -> Figure:
    """``time`` s, ``acceleration`` m/s², ``velocity`` m/s and ``displacement`` m, all ``(n,)``."""
    t = TIME.of(time)
    rows = ((ACCELERATION, acceleration), (VELOCITY, velocity), (DISPLACEMENT, displacement))
    with style.panels(5.4, 3, 1, title, sharex=True) as (fig, axes):
        for panel, (axis, values) in zip(axes[:, 0], rows, strict=True):
            y = axis.of(values)
            peak = int(np.argmax(np.abs(y)))
            style.line(panel, t, y, color=style.BLUE, lw=0.8)
            panel.plot(t[peak], y[peak], "o", ms=4, color=style.VERMILLION)
            panel.set_title(f"largest sample {abs(y[peak]):.4g} {axis.unit} at {t[peak]:.4g} s", fontsize=9)
            panel.set_ylabel(axis.label)
        axes[-1, 0].set_xlabel(TIME.label)
        axes[-1, 0].set_xlim(t[0], t[-1])
        fig.align_ylabels(axes[:, 0])
    return fig
