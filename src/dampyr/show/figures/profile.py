"""The profile of an objective over one coefficient: the curve, the parabola of its standard error, threshold and interval."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RISE = Axis("adjusted rise", "1")
SHOWN = 2.5  # times the threshold: what is higher says no more


def profile_curve(
    axis: Axis,
    values: ArrayLike,
    rise: ArrayLike,
    threshold: float,
    interval: tuple[float, float],
    parabola: tuple[float, float] | None = None,
    title: str = "",
) -> Figure:
    """``values`` (n,) SI of the coefficient on ``axis``, the ``rise`` (n,) there, and where it is allowed to lie.

    ``parabola`` is the estimate and its standard error; an end of the ``interval`` that is not finite is not drawn.
    """
    x, y = axis.of(values), np.asarray(rise, dtype=float)
    with style.single_panel(2.6, title) as (fig, panel):
        panel.axhline(threshold, color=style.MUTED, lw=0.9, ls="--", label="threshold")
        if parabola is not None:
            grid = np.linspace(float(np.min(values)), float(np.max(values)), 200)
            parabola_rise = ((grid - parabola[0]) / parabola[1]) ** 2
            panel.plot(axis.of(grid), parabola_rise, color=style.SKY, lw=1.0, label="parabola of the error")
        panel.plot(x, y, "o-", ms=2.5, color=style.BLUE, label="profile")
        low, high = (axis.of(end) if np.isfinite(end) else None for end in interval)
        for end in (low, high):
            if end is not None:
                panel.axvline(float(end), color=style.VERMILLION, lw=0.9)
        if low is not None and high is not None:
            panel.axvspan(float(low), float(high), color=style.VERMILLION, alpha=0.08, lw=0, label="interval")
        panel.set_ylim(0.0, SHOWN * threshold)
        style.name_axes(panel, axis, RISE)
        style.legend(fig, panel, columns=4)
    return fig
