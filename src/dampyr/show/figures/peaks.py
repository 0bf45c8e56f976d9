"""Peaks by floor or storey: one line of markers a case, the building drawn upright."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def peaks_by_floor(
    floors: Sequence[str],
    cases: Mapping[str, Sequence[ArrayLike]],
    axes: Sequence[Axis] = (DISPLACEMENT,),
    title: str = "",
    colours: Mapping[str, str] | None = None,
) -> Figure:
    """One panel for each of ``axes``; ``cases`` name -> one SI array ``(n,)`` for each panel, the lowest floor first.

    The first case is drawn grey unless ``colours`` (name -> colour) says else.
    """
    colours = colours or style.case_colours(cases, next(iter(cases)))
    height = np.arange(len(floors))
    with style.panels(1.6 + 0.32 * len(floors), 1, len(axes), title, sharey=True) as (fig, panels):
        for k, (panel, axis) in enumerate(zip(panels[0], axes, strict=True)):
            for name, values in cases.items():
                panel.plot(axis.of(values[k]), height, "o-", ms=5, lw=1.2, color=colours[name], label=name)
            panel.set_xlim(0.0, 1.08 * max(float(np.max(axis.of(values[k]))) for values in cases.values()) or 1.0)
            panel.set_xlabel(axis.label)
        panels[0, 0].set_yticks(height, floors)
        panels[0, 0].set_ylabel("floor")
        panels[0, 0].set_ylim(-0.5, len(floors) - 0.5)
        style.legend(fig, panels[0, 0])
    return fig
