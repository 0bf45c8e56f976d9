"""Every model that was tried: its error bare, and with the add-ons that were worth it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from dampyr.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from dampyr.identification import Leaderboard, Screened


def leaderboard_figure(board: Leaderboard) -> Figure:
    """One row a model, the best on top; models that made no damper at all are left to the table."""
    shown = sorted((s for s in board.screened if math.isfinite(s.best.error)), key=lambda s: s.best.error)
    fig, axes = style.figure(1.0 + 0.36 * max(len(shown), 2), 1, 1)
    panel = axes[0, 0]
    with style.style():
        for row, one in enumerate(shown):
            bare, best = 100 * one.bare.error, 100 * one.best.error
            if math.isfinite(bare):
                panel.plot([best, bare], [row, row], "-", color=style.MUTED, lw=1.2)
                panel.plot(bare, row, "o", ms=6, mfc="none", mew=1.4, color=style.VERMILLION, label=_first("bare", row))
            panel.plot(best, row, "o", ms=6, color=style.BLUE, label=_first("with add-ons", row))
        panel.set_yticks(range(len(shown)), [_name(one) for one in shown])
        panel.invert_yaxis()
        panel.set_xlim(left=0)
        panel.grid(visible=False, axis="y")
        panel.set_xlabel("validation error [%]")
        style.legend(fig, panel)
    return fig


def _name(one: Screened) -> str:
    return one.best.model.replace(one.base, one.base + "\n", 1).replace("\n + ", "\n+ ").rstrip("\n")


def _first(name: str, row: int) -> str | None:
    return name if row == 0 else None
