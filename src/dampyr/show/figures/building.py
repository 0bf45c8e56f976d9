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
    """A quantity of several cases over time: up to `TOGETHER` over one another, of more each in a panel over the first.

    Parameters
    ----------
    time
        s, ``(n,)``.
    cases
        Name -> the quantity, SI, ``(n,)``; a name is followed by the greatest magnitude among the samples shown.
    axis
        What the quantity is, and the unit that it is shown in.
    title
        Above the figure.
    colours
        Name -> colour; by default the first case, with which the others are compared, is grey.

    Examples
    --------
    >>> import numpy as np
    >>> from dampyr.show.figures.building import building_response
    >>> time = np.linspace(0.0, 10.0, 500)
    >>> figure = building_response(time, {"no damper": 0.01 * np.sin(time), "0 V": 0.004 * np.sin(time)})
    >>> [str(line.get_label()) for line in figure.axes[0].lines][::2]
    ['no damper: 10 mm', '0 V: 4 mm']
    """
    first = next(iter(cases))
    colours = colours or style.case_colours(cases, first)
    groups = [list(cases)] if len(cases) <= TOGETHER else [[first, name] for name in list(cases)[1:]]
    height = 2.7 if len(groups) == 1 else 0.85 + 0.52 * len(groups)
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
