"""What control does: a quantity of several cases over one another, and below it the input of each law in the strong motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, TIME, VOLTAGE, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
STRONG = 2.0  # s of an input that are shown


def controlled(
    time: ArrayLike,
    cases: Mapping[str, ArrayLike],
    inputs: Mapping[str, ArrayLike],
    axis: Axis = DISPLACEMENT,
    input_axis: Axis = VOLTAGE,
    title: str = "",
    colours: Mapping[str, str] | None = None,
    means: Mapping[str, float] | None = None,
) -> Figure:
    """A quantity of several cases over one another, and below it the input that each law set in the strongest two seconds.

    How much of the whole time its samples are in the upper half of their range stands above each.

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
    means
        Name -> the mean of the input over the whole time, V or A, which stands above it.
    """
    count = len(inputs)
    colours = colours or style.case_colours(cases, next(iter(cases)))
    t, ratios = TIME.of(time), (2.0, *[1.0] * count)
    begin, end = _strong_motion(t, [np.asarray(cases[name], dtype=float) for name in inputs])
    with style.panels(2.4 + 0.95 * count, 1 + count, 1, title, height_ratios=ratios) as (fig, axes):
        top = axes[0, 0]
        for name, values in cases.items():
            style.line_with_peak(top, time, values, axis, name, colours[name])
        top.axvspan(begin, end, color=style.SKY, alpha=0.25, lw=0)
        top.set_ylabel(axis.label)
        top.set_xlim(t[0], t[-1])
        inside = (t >= begin) & (t <= end)
        for panel, (name, values) in zip(axes[1:, 0], inputs.items(), strict=True):
            shown = input_axis.of(values)
            panel.step(t[inside], shown[inside], where="pre", color=colours[name], lw=1.2)
            panel.set_ylabel(input_axis.label)
            panel.set_xlim(begin, end)
            panel.set_title(_in_words(name, shown, (means or {}).get(name), input_axis.unit), fontsize=9.0)
            panel.tick_params(labelbottom=panel is axes[-1, 0])
        axes[-1, 0].set_xlabel(TIME.label)
        style.legend(fig, top, columns=2, min_entries=1)
    return fig


def _strong_motion(t: Array, cases: Sequence[Array]) -> tuple[float, float]:
    """`STRONG` s about the greatest sample of any case: an input that switches is a block of ink over the whole time."""
    largest = np.max(np.abs(cases), axis=0)
    begin = min(
        max(float(t[int(np.argmax(largest))]) - 0.5 * STRONG, float(t[0])), max(float(t[-1]) - STRONG, float(t[0]))
    )
    return begin, min(begin + STRONG, float(t[-1]))


def _in_words(name: str, values: Array, mean: float | None, unit: str) -> str:
    """The mean of an input, and how much of the time its samples are in the upper half of their range."""
    low, high = float(values.min()), float(values.max())
    facts = [] if mean is None else [f"mean {mean:.3g} {unit}"]
    if low < high:
        share = float(np.mean(values > 0.5 * (low + high)))
        facts.append(f"above {0.5 * (low + high):.3g} {unit} for {100 * share:.0f} % of the time")
    return f"{name}: {', '.join(facts)}" if facts else name
