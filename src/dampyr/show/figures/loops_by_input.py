"""Loops of several records beside one another: measured and modelled force over displacement, a panel each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, FORCE

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike


@dataclass(frozen=True)
class RecordLoop:
    """A record's displacement m and measured force N, and the force N of each model by its name, ``(n,)`` each."""

    displacement: ArrayLike
    measured: ArrayLike
    models: Mapping[str, ArrayLike]


def loops_by_input(loops: Mapping[str, RecordLoop], record_origin: Origin = NOT_STATED) -> Figure:
    """A panel for each of ``loops``, under its name, such as ``1.98 V``; one scale of force for all of them."""
    with style.panels(2.2, 1, len(loops), sharey=True) as (fig, axes):
        for panel, (name, loop) in zip(axes[0], loops.items(), strict=True):
            x = DISPLACEMENT.of(loop.displacement)
            style.line(panel, x, FORCE.of(loop.measured), color=style.MEASURED, lw=1.2, label=record_origin.series)
            for colour, (model, force) in zip(style.SERIES, loop.models.items(), strict=False):
                panel.plot(*style.thin(x, FORCE.of(force)), color=colour, lw=1.1, label=model)
            panel.set_title(name, loc="left", fontsize=9.5)
        axes[0, 0].set_ylabel(FORCE.label)
        fig.supxlabel(DISPLACEMENT.label, fontsize=10)  # once: under each of four panels it would run into the next
        style.legend(fig, axes[0, 0])
    return fig
