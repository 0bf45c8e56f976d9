"""How a building answers: one quantity of several cases, each with its peak marked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, TIME, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOGETHER = 3  # cases that can be told apart over one another; more of them stand in panels of their own


def building_response(
    time: ArrayLike,
    cases: Mapping[str, ArrayLike],
    axis: Axis = DISPLACEMENT,
    title: str = "",
    colours: Mapping[str, str] | None = None,
) -> Figure:
    """``time`` s ``(n,)``; ``cases`` name -> SI ``(n,)``; the first is drawn grey, as what to compare with.

    Up to `TOGETHER` cases lie over one another; of more, each has a panel of its own over the first. Each name is followed by
    the greatest magnitude among the samples shown. ``colours`` name -> colour are those of the page.
    """
    first = next(iter(cases))
    colours = colours or style.case_colours(cases, first)
    groups = [list(cases)] if len(cases) <= TOGETHER else [[first, name] for name in list(cases)[1:]]
    height = 3.0 if len(groups) == 1 else 0.95 + 0.68 * len(groups)
    t = TIME.of(time)
    with style.panels(height, len(groups), 1, title, sharex=True, sharey=True) as (fig, axes):
        for panel, names in zip(axes[:, 0], groups, strict=True):
            for name in names:
                style.line_with_peak(panel, time, cases[name], axis, name, colours[name])
        panel = axes[-1, 0]
        if len(groups) == 1:
            panel.set_ylabel(axis.label)
        else:
            fig.supylabel(axis.label, fontsize=10)
        panel.set_xlim(t[0], t[-1])
        panel.set_xlabel(TIME.label)
        style.legend(fig, *axes[:, 0], columns=2, min_entries=1)
    return fig
