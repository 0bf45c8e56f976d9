"""Hysteresis loops: force against displacement and against velocity, measured and modelled."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, FORCE, VELOCITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def loops(
    displacement: ArrayLike,
    velocity: ArrayLike | None,
    measured: ArrayLike | None,
    models: Mapping[str, ArrayLike] | None = None,
    title: str = "",
    colours: Mapping[str, str] | None = None,
    points: int = style.POINTS,
    record_origin: Origin = NOT_STATED,
    share: float = 1.0,
) -> Figure:
    """Force-displacement and, with a velocity, force-velocity loops.

    Parameters
    ----------
    displacement
        m, ``(n,)``; all channels are on one clock.
    velocity
        m/s, ``(n,)``; without it there is one panel.
    measured
        The measured force, N, ``(n,)``; None where nothing was measured.
    models
        Name -> modelled force, N, ``(n,)``.
    title
        Above the figure.
    colours
        Name of a model -> its colour; by default the series of the style.
    points
        How many points a line of a model has at most.
    record_origin
        Origin of what is taken for ``measured``, which says what its line is called.
    share
        How much of the width of a page the figure has.

    Examples
    --------
    >>> import numpy as np
    >>> from dampyr.show.figures.loops import loops
    >>> phase = np.linspace(0.0, 2 * np.pi, 200)
    >>> figure = loops(0.01 * np.sin(phase), 0.06 * np.cos(phase), 90.0 * np.cos(phase))
    >>> [panel.get_xlabel() for panel in figure.axes]
    ['displacement [mm]', 'velocity [mm/s]']
    """
    panels = [(displacement, DISPLACEMENT)] + ([(velocity, VELOCITY)] if velocity is not None else [])
    with style.panels(2.6, 1, len(panels), title, share, sharey=True) as (fig, axes):
        for panel, (values, axis) in zip(axes[0], panels, strict=True):
            x = axis.of(values)
            if measured is not None:
                style.line(panel, x, FORCE.of(measured), color=style.MEASURED, lw=1.2, label=record_origin.series)
            for colour, (name, force) in zip(cycle(style.SERIES), (models or {}).items(), strict=False):
                colour = (colours or {}).get(name, colour)
                panel.plot(*style.thin(x, FORCE.of(force), points), color=colour, lw=1.1, label=name)
            style.name_axes(panel, axis, FORCE)
            panel.label_outer(remove_inner_ticks=False)
        style.legend(fig, axes[0, 0], min_entries=2 if measured is not None or len(models or {}) != 1 else 1)
    return fig
