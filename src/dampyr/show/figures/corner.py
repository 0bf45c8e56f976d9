"""A corner plot: samples of several numbers, each by itself on the diagonal and each pair of them below it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.sample_pairs import DOTS, ellipse
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BINS = 30
TICKS = 3  # of an axis of a small panel


def corner(
    samples: Mapping[str, ArrayLike], axes: Mapping[str, Axis], estimates: Mapping[str, float], title: str = ""
) -> Figure:
    """``samples`` name -> (n,) SI of the numbers to draw, with the ``axes`` and the ``estimates`` of these names.

    On the diagonal stand histograms, below it a cloud for each pair, with the line that holds 95 % of a normal distribution;
    the fit's estimate is marked in each.

    Examples
    --------
    >>> import numpy as np
    >>> from dampyr.show.figures.corner import corner
    >>> from dampyr.show.figures.style import Axis
    >>> draws = np.random.default_rng(0).normal(size=(2, 500))
    >>> names = {"a": Axis("a", "N"), "b": Axis("b", "mm", 1e3)}
    >>> figure = corner(dict(zip("ab", draws)), names, {"a": 0.0, "b": 0.0})
    >>> [panel.get_xlabel() for panel in figure.axes if panel.get_xlabel()]
    ['a [N]', 'b [mm]']
    """
    names = list(samples)
    size = min(1.55, 6.6 / len(names))  # inches: of three numbers and fewer the panels do not grow beyond the page
    with style.panels(0.6 + size * len(names), len(names), len(names), title, sharex="col") as (fig, grid):
        for row, up in enumerate(names):
            for column, across in enumerate(names):
                panel = grid[row, column]
                if column > row:
                    panel.set_axis_off()
                    continue
                x = axes[across].of(samples[across])
                if column == row:
                    panel.hist(x, BINS, color=style.SKY, alpha=0.5)
                    panel.axvline(float(axes[up].of(estimates[up])), color=style.VERMILLION, lw=1.2)
                    panel.set_yticks([])
                    panel.grid(visible=False, axis="y")
                else:
                    _cloud(panel, x, axes[up].of(samples[up]))
                    centre = float(axes[across].of(estimates[across])), float(axes[up].of(estimates[up]))
                    panel.plot(*centre, "+", ms=9, mew=1.6, color=style.VERMILLION, ls="", label="fit")
                _label(panel, axes[across], axes[up], row == len(names) - 1, 0 == column < row)
        fig.align_labels()
        style.legend(fig, *grid.flat)
    return fig


def _cloud(panel: Any, x: ArrayLike, y: ArrayLike) -> None:
    every = max(np.size(x) // DOTS, 1)
    panel.plot(np.asarray(x)[::every], np.asarray(y)[::every], ".", ms=1.5, alpha=0.3, color=style.BLUE, label="sample")
    panel.plot(*ellipse(x, y), color=style.INK, lw=0.9, label="95 % of a normal distribution")


def _label(panel: Any, across: Axis, up: Axis, lowest: bool, leftmost: bool) -> None:
    """Names of the axes at the edges of the corner only, and few ticks, for the panels are small."""
    from matplotlib.ticker import MaxNLocator

    panel.xaxis.set_major_locator(MaxNLocator(TICKS))
    if panel.get_yticks().size:
        panel.yaxis.set_major_locator(MaxNLocator(TICKS))
    panel.ticklabel_format(useOffset=False)  # what all ticks share would stand over the label beside it
    panel.tick_params(labelbottom=lowest, labelleft=leftmost)
    if lowest:
        panel.set_xlabel(across.label)
    if leftmost:
        panel.set_ylabel(up.label)
