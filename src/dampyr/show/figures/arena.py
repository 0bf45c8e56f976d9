"""How often each of several inputs is the best, with bands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BEST = Axis("best of all inputs", "% of the cases", 100.0)


def shares_of_best(
    names: Sequence[str], best: NDArray[np.float64], band: NDArray[np.float64], title: str = ""
) -> Figure:
    """``names`` (k,) from the top with their shares ``best`` (k,), 0 to 1, and 90 % ``band`` (2, k), NaN for none."""
    with style.single_panel(1.0 + 0.45 * len(names), title) as (fig, panel):
        places = np.arange(len(names))[::-1]
        low, high = BEST.of(band[0]), BEST.of(band[1])
        panel.hlines(places, low, high, color=style.BLUE, lw=3.0, alpha=0.35, label="90 % band")
        panel.plot(BEST.of(best), places, "o", ms=6, color=style.BLUE, label="share")
        for name, place in zip(
            names, places, strict=True
        ):  # above its band: beside the axis long names leave it no room
            panel.text(0.0, place + 0.2, name, va="bottom", fontsize="small")
        panel.set_yticks([])
        panel.set_xlim(-2.0, 102.0)
        panel.set_ylim(-0.6, len(names) - 0.2)
        panel.set_xlabel(BEST.label)
        panel.grid(axis="x", alpha=0.3)
        style.legend(fig, panel)
    return fig
