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
) -> Figure:
    """Force-displacement and, with a velocity, force-velocity loops.

    ``displacement`` m, ``velocity`` m/s or None, ``measured`` N or None where nothing was measured,
    ``models`` name -> N; all ``(n,)`` on one clock. ``colours`` name -> colour are those of the page, ``points`` the
    number of points of a line at most, ``record_origin`` that of what is taken for ``measured``.
    """
    panels = [(displacement, DISPLACEMENT)] + ([(velocity, VELOCITY)] if velocity is not None else [])
    fig, axes = style.figure(2.7, 1, len(panels), title, sharey=True)
    with style.style():
        for panel, (values, axis) in zip(axes[0], panels, strict=True):
            x = axis.of(values)
            if measured is not None:
                style.line(panel, x, FORCE.of(measured), color=style.MEASURED, lw=1.2, label=record_origin.series)
            for colour, (name, force) in zip(cycle(style.SERIES), (models or {}).items(), strict=False):
                own = (colours or {}).get(name, colour)
                panel.plot(*style.thin(x, FORCE.of(force), points), color=own, lw=1.1, label=name)
            style.name_axes(panel, axis, FORCE)
            panel.label_outer(remove_inner_ticks=False)
        style.legend(fig, axes[0, 0], min_entries=2 if measured is not None or len(models or {}) != 1 else 1)
    return fig
