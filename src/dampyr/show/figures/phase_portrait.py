"""The phase portrait of a hysteresis model: its output over its input, both as the model has them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def phase_portrait(
    x: Axis,
    y: Axis,
    curves: Mapping[str, tuple[ArrayLike, ArrayLike]],
    limits: Mapping[str, float] | None = None,
    title: str = "",
    share: float = 1.0,
) -> Figure:
    """``curves`` name -> (values on x, values on y); ``limits`` name -> a level of y, drawn on both sides.

    ``share``: of the page's width.
    """
    with style.single_panel(2.6, title, share) as (fig, panel):
        for colour, (name, (across, up)) in zip(cycle(style.SERIES[1:]), curves.items(), strict=False):
            style.line(panel, x.of(across), y.of(up), color=colour, label=name)
        for name, level in (limits or {}).items():
            for side, label in ((1.0, name), (-1.0, None)):
                panel.axhline(side * float(np.asarray(y.of(level))), color=style.MUTED, ls="--", lw=1, label=label)
        style.name_axes(panel, x, y)
        style.legend(fig, panel)
    return fig
