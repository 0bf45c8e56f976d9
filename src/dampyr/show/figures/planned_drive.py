"""What table and coil are to do in one test: position, speed and voltage over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, TIME, VELOCITY, VOLTAGE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def planned_drive(
    time: ArrayLike, displacement: ArrayLike, voltage: ArrayLike, title: str = "", colour: str = style.BLUE
) -> Figure:
    """``time`` s, ``displacement`` m and ``voltage`` V, all ``(n,)``; the speed is that between set points.

    ``colour`` is that of the test in its page.
    """
    t = TIME.of(time)
    x = np.asarray(displacement, dtype=float)
    rows = ((DISPLACEMENT, x), (VELOCITY, np.gradient(x, t)), (VOLTAGE, voltage))
    with style.panels(4.4, 3, 1, title, sharex=True, height_ratios=(1.6, 1.6, 1)) as (fig, axes):
        for panel, (axis, values) in zip(axes[:, 0], rows, strict=True):
            style.line(
                panel,
                t,
                axis.of(values),
                color=colour,
                lw=0.9,
                drawstyle="steps-post" if axis is VOLTAGE else "default",
            )
            panel.set_ylabel(axis.label)
        axes[-1, 0].set_xlabel(TIME.label)
        axes[-1, 0].set_xlim(t[0], t[-1])
        fig.align_ylabels(axes[:, 0])
    return fig
