"""Loops of several records over one another, and what goes with them: force over speed, the backbone, energy by cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, FORCE, VELOCITY, Axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_NAMES = 12  # in a legend

Loop = tuple[ArrayLike, ArrayLike, ArrayLike]
Points = tuple[ArrayLike, ArrayLike]


def loop_overlay(
    loops: Mapping[str, Sequence[Loop]],
    displacement: Axis = DISPLACEMENT,
    velocity: Axis = VELOCITY,
    force: Axis = FORCE,
    title: str = "",
) -> Figure:
    """Force over displacement and over velocity: ``loops`` name -> displacement m, velocity m/s and force N of its cycles.

    A name has one colour, such as a specimen or a setting. The axes say in which unit they are.
    """
    colours = style.case_colours(loops)
    with style.panels(3.1, 1, 2, title, sharey=True) as (fig, axes):
        for name, cycles in loops.items():
            for k, (x, v, f) in enumerate(cycles):
                for panel, values, axis in ((axes[0, 0], x, displacement), (axes[0, 1], v, velocity)):
                    label = name if k == 0 else None
                    style.line(panel, axis.of(values), force.of(f), color=colours[name], lw=0.9, label=label)
        for panel, axis in zip(axes[0], (displacement, velocity), strict=True):
            style.name_axes(panel, axis, force)
            panel.label_outer(remove_inner_ticks=False)
        _legend(fig, axes[0, 0], len(loops))
    return fig


def curve_overlay(
    curves: Mapping[str, Sequence[Points]], x: Axis, y: Axis, title: str = "", zero: bool = False
) -> Figure:
    """Points joined by lines: ``curves`` name -> SI values of ``x`` and ``y``, in one colour; with ``zero`` y begins there."""
    colours = style.case_colours(curves)
    with style.single_panel(2.9, title) as (fig, panel):
        for name, lines in curves.items():
            for k, (horizontal, vertical) in enumerate(lines):
                label = name if k == 0 else None
                panel.plot(x.of(horizontal), y.of(vertical), "o-", ms=3.5, lw=1.0, color=colours[name], label=label)
        if zero:
            panel.set_ylim(bottom=0.0)
        style.name_axes(panel, x, y)
        _legend(fig, panel, len(curves))
    return fig


def _legend(fig: Figure, panel: Axes, names: int) -> None:
    """The names, where they are not so many that they would take the place of what they name."""
    if names <= MOST_NAMES:
        style.legend(fig, panel)
