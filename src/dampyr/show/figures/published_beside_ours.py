"""How far the numbers of a study that was run again are from the published ones, a row an artefact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from dampyr.show.figures import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINEAR = 1e-3  # of the published number: smaller differences are drawn to scale, larger ones by their logarithm
TICKS = (-1.0, -0.01, 0.0, 0.01, 1.0)
LOOKS = {
    "agrees": {"marker": "o", "color": style.GREEN, "ms": 4.5},
    "differs": {"marker": "D", "color": style.VERMILLION, "ms": 4.5, "mfc": "none", "mew": 1.2},
}


def published_beside_ours(deviations: Mapping[str, Sequence[tuple[float, str]]], title: str = "") -> Figure:
    """``deviations`` artefact -> (ours/published - 1, "agrees" or "differs") of each of its numbers.

    Examples
    --------
    >>> from dampyr.show.figures.published_beside_ours import published_beside_ours
    >>> figure = published_beside_ours({"Table 1": [(0.0002, "agrees"), (-0.12, "differs")]})
    >>> figure.axes[0].get_xlabel()
    'ours less published [% of published]'
    """
    with style.single_panel(max(0.9 + 0.17 * len(deviations), 3.0), title) as (fig, panel):
        for row, numbers in enumerate(deviations.values()):
            for outcome, look in LOOKS.items():
                x = [deviation for deviation, judged in numbers if judged == outcome]
                panel.plot(x, [row] * len(x), ls="", label=outcome, clip_on=False, zorder=3, **look)
        panel.axvline(0.0, color=style.MUTED, lw=0.9)
        panel.set_xscale("symlog", linthresh=LINEAR, linscale=0.6)
        drawn = [deviation for numbers in deviations.values() for deviation, _ in numbers]
        low, high = 1.6 * min(drawn), 1.6 * max(drawn)
        low, high = min(low, -2.0 * LINEAR, -0.1 * high), max(high, 2.0 * LINEAR, -0.1 * low)
        ticks = [tick for tick in TICKS if low <= tick <= high]
        panel.set_xlim(low, high)
        panel.set_xticks(ticks, [_percent(tick) for tick in ticks], fontsize=8.0)
        panel.set_xticks([], minor=True)
        panel.set_yticks(np.arange(len(deviations)), list(deviations), fontsize=8.0)
        panel.set_ylim(len(deviations) - 0.4, -0.6)
        panel.set_xlabel("ours less published [% of published]")
        style.legend(fig, panel, min_entries=1)
    return fig


def _percent(ratio: float) -> str:
    return f"{100 * ratio:+,.10g}".replace("-", "−").replace(",", " ") if ratio else "0"
