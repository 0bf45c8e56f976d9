"""The autocorrelation of residuals over the lag: every record thin, their mean thick, the correlation time marked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LAG = Axis("lag", "s")
RHO = Axis("autocorrelation", "1")
POINTS = 160  # of one curve: dozens of records lie over one another, and the file stays small


def memory(records: Sequence[tuple[ArrayLike, ArrayLike]], correlation_time: float, title: str = "") -> Figure:
    """``records``: (lags s, autocorrelations) of each, from lag 0; ``correlation_time`` s of all together."""
    with style.single_panel(2.8, title, style.THIRD) as (fig, panel):
        panel.axhline(0.0, color=style.MUTED, lw=0.8)
        for lags, rho in records:
            x, y = style.thin(lags, rho, POINTS)
            panel.plot(x, y, color=style.SKY, lw=0.7, alpha=0.55, label="record" if len(records) > 1 else None)
        # records are of unequal length: at each lag the mean is over those that have it
        lags = max((np.asarray(lags, dtype=float) for lags, _ in records), key=lambda lags: lags[-1])
        mean = np.nanmean([np.interp(lags, np.asarray(x), np.asarray(rho), right=np.nan) for x, rho in records], axis=0)
        style.line(panel, lags, mean, color=style.BLUE, lw=1.6, label="mean" if len(records) > 1 else "the record")
        label = f"correlation time {correlation_time:.2g} s"
        panel.axvline(correlation_time, color=style.VERMILLION, ls="--", lw=1.1, label=label)
        panel.set_xlim(0.0, float(lags[-1]))
        panel.set_ylim(-1.05, 1.05)
        style.name_axes(panel, LAG, RHO)
        style.legend(fig, panel, columns=2)
    return fig
