"""A measured force in its predictive band."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures import style
from dampyr.show.figures.style import FORCE, TIME

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def band(
    time: ArrayLike,
    measured: ArrayLike,
    low: ArrayLike,
    high: ArrayLike,
    level: float = 0.9,
    title: str = "",
    record_origin: Origin = NOT_STATED,
) -> Figure:
    """The measured force (n,) N over time (n,) s, in the band from ``low`` to ``high`` (n,) N that is to hold ``level``
    of it."""
    t, force = np.asarray(time, dtype=float), FORCE.of(measured)
    below, above = FORCE.of(low), FORCE.of(high)
    with style.single_panel(2.8, title) as (fig, panel):
        step = max(t.size // style.POINTS, 1)  # a filled band of every sample is a page of its own
        panel.fill_between(
            t[::step],
            below[::step],
            above[::step],
            color=style.SKY,
            alpha=0.45,
            lw=0.0,
            label=f"{100 * level:g} % band",
        )
        style.line(panel, t, force, color=style.INK, lw=0.9, label=record_origin.series)
        outside = (force < below) | (force > above)
        if outside.any():
            panel.plot(t[outside], force[outside], ".", color=style.VERMILLION, ms=2.0, label="outside")
        panel.set_xlabel(TIME.label)
        panel.set_ylabel(FORCE.label)
        style.legend(fig, panel)
    return fig
