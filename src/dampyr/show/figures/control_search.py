"""Candidates beside the first of them: ratios with bands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def ratios(names: Sequence[str], ratio: NDArray[np.float64], band: NDArray[np.float64], what: str) -> Figure:
    """``names`` (k,) from the top, with the ``ratio`` (k,) of ``what`` to the first's and its 90 % ``band`` (2, k)."""
    with style.single_panel(1.0 + 0.45 * len(names), "") as (fig, panel):
        places = np.arange(len(names))[::-1]
        axis = Axis(f"{what}, of the first's", "%", 100.0)
        low, high, at = axis.of(band[0]), axis.of(band[1]), axis.of(ratio)
        panel.axvline(100.0, color="0.6", lw=1.0)
        panel.hlines(places, low, high, color=style.BLUE, lw=3.0, alpha=0.35, label="90 % band")
        panel.plot(at, places, "o", ms=6, color=style.BLUE, label="where it was not chosen")
        left = min(float(low.min()), 100.0)
        span = max(float(high.max()) - left, 2.0)
        for name, place in zip(names, places, strict=True):
            panel.text(left, place + 0.2, name, va="bottom", fontsize="small")
        panel.set_yticks([])
        panel.set_xlim(left - 0.03 * span, left + 1.05 * span)
        panel.set_ylim(-0.6, len(names) - 0.2)
        panel.set_xlabel(axis.label)
        panel.grid(axis="x", alpha=0.3)
        style.legend(fig, panel)
    return fig
