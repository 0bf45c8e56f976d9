"""What control does: one quantity of several cases over one another, and below it the input that each law set."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, TIME, VOLTAGE, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def controlled(
    time: ArrayLike,
    cases: Mapping[str, ArrayLike],
    inputs: Mapping[str, ArrayLike],
    axis: Axis = DISPLACEMENT,
    input_axis: Axis = VOLTAGE,
    title: str = "",
    colours: Mapping[str, str] | None = None,
) -> Figure:
    """``time`` s ``(n,)``; ``cases`` name -> SI ``(n,)``, the first drawn grey unless ``colours`` (name -> colour) says else;
    ``inputs`` of some of these, V or A ``(n,)``, one panel each. Each name is followed by the greatest magnitude among the
    samples shown.
    """
    count = len(inputs)
    colours = colours or style.case_colours(cases, next(iter(cases)))
    t, ratios = TIME.of(time), (2.2, *[1.0] * count)
    with style.panels(2.5 + 1.05 * count, 1 + count, 1, title, sharex=True, height_ratios=ratios) as (fig, axes):
        top = axes[0, 0]
        for name, values in cases.items():
            style.line_with_peak(top, time, values, axis, name, colours[name])
        top.set_ylabel(axis.label)
        for panel, (name, values) in zip(axes[1:, 0], inputs.items(), strict=True):
            panel.step(t, input_axis.of(values), where="pre", color=colours[name], lw=1.0)
            panel.set_ylabel(input_axis.label)
        axes[-1, 0].set_xlabel(TIME.label)
        axes[-1, 0].set_xlim(t[0], t[-1])
        style.legend(fig, top, columns=2, min_entries=1)
    return fig
