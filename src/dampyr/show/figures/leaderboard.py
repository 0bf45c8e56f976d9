"""Every model that was tried: its error bare, and with the add-ons that were worth it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from dampyr.show.figures import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def leaderboard_figure(models: Sequence[str], bare: Sequence[float], best: Sequence[float]) -> Figure:
    """One row a model, the best on top: the validation errors ``bare`` and ``best`` (with add-ons), as ratios.

    Models without a finite ``best`` made no damper at all and are left to the table.
    """
    shown = sorted((row for row in zip(models, bare, best) if math.isfinite(row[2])), key=lambda row: row[2])
    with style.single_panel(1.0 + 0.36 * max(len(shown), 2)) as (fig, panel):
        for row, (_, alone, combined) in enumerate(shown):
            if math.isfinite(alone):
                panel.plot([100 * combined, 100 * alone], [row, row], "-", color=style.MUTED, lw=1.2)
                panel.plot(100 * alone, row, "o", ms=6, mfc="none", mew=1.4, color=style.VERMILLION, label="bare")
            panel.plot(100 * combined, row, "o", ms=6, color=style.BLUE, label="with add-ons")
        panel.set_yticks(range(len(shown)), [name for name, _, _ in shown])
        panel.set_ylim(len(shown) - 0.5, -0.5)
        panel.set_xlim(left=0)
        panel.grid(visible=False, axis="y")
        panel.set_xlabel("validation error [%]")
        style.legend(fig, panel)
    return fig
