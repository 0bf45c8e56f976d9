"""Loops of several dampers beside one another on the same axes: one damper of one case in each square."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import FORCE, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STROKE = Axis("stroke", "mm", 1e3)
MOST = 5  # squares in a row of the page's width
LETTER = 0.075  # inches of a letter of a title


def loops_by_case(loops: Mapping[str, tuple[ArrayLike, ArrayLike]], colours: Mapping[str, str] | None = None) -> Figure:
    """``loops`` name -> (stroke m, force N) ``(n,)``, a square each; ``colours`` name -> colour are those of the page.

    Examples
    --------
    >>> import numpy as np
    >>> from dampyr.show.figures.loops_by_case import loops_by_case
    >>> phase = np.linspace(0.0, 2 * np.pi, 200)
    >>> x, force = 0.01 * np.sin(phase), 90.0 * np.cos(phase)
    >>> figure = loops_by_case({"0 V": (x, force), "1.98 V": (0.4 * x, 5.0 * force)})
    >>> [panel.get_title(loc="left") for panel in figure.axes]
    ['0 V', '1.98 V']
    """
    count = len(loops)
    columns = count if count <= MOST else math.ceil(count / math.ceil(count / MOST))
    rows = math.ceil(count / columns)
    side = min(style.WIDTH / columns, 2.6)
    colours = colours or style.case_colours(loops)
    with style.panels(0.45 + rows * (side + 0.2), rows, columns, sharex=True, sharey=True) as (fig, axes):
        for panel, (name, (stroke, force)) in zip(axes.flat, loops.items(), strict=False):
            panel.plot(STROKE.of(stroke), FORCE.of(force), color=colours[name], lw=0.8)
            panel.set_box_aspect(1.0)
            panel.set_title(textwrap.fill(name, round(side / LETTER)), fontsize=8.5)
        for empty in axes.flat[count:]:
            empty.set_axis_off()
        for panel in axes[:, 0]:
            panel.set_ylabel(FORCE.label)
        for panel in axes.flat[max(count - columns, 0) : count]:  # the lowest of each column
            panel.set_xlabel(STROKE.label)
            panel.tick_params(labelbottom=True)
    return fig
