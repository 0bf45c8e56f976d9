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
    """A quantity of several cases over one another, and below it a panel for each input that a law set.

    Parameters
    ----------
    time
        s, ``(n,)``.
    cases
        Name -> the quantity, SI, ``(n,)``; a name is followed by the greatest magnitude among the samples shown.
    inputs
        Name of some of these cases -> the input of their damper, V or A, ``(n,)``.
    axis, input_axis
        What the quantity and the inputs are, and the units that they are shown in.
    title
        Above the figure.
    colours
        Name -> colour; by default the first case is grey.
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
