"""The size of the residual of each record against its input, its stroke and its frequency."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.calibration_range import FREQUENCY, looks
from dampyr.show.figures.style import VOLTAGE, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = Axis("rms residual / spread", "%", 100.0)
STROKE = Axis("stroke", "mm", 1e3)


def residual_sizes(
    groups: Mapping[str, tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike]],
    axis: Axis | None = VOLTAGE,
    title: str = "",
    colours: Mapping[str, str] | None = None,
) -> Figure:
    """``groups`` name -> (inputs V or A, strokes m peak to peak, frequencies Hz, rms residual over the force's spread).

    ``colours`` name -> colour are those of the page. Without an ``axis`` there is no input, and no panel of it.
    """
    across_axes = (axis, STROKE, FREQUENCY) if axis else (STROKE, FREQUENCY)
    with style.panels(2.8, 1, len(across_axes), title, style.TWO_THIRDS, sharey=True) as (fig, axes):
        for look, (name, (*across, size)) in zip(looks(groups, colours), groups.items(), strict=True):
            for panel, x, values in zip(axes[0], across_axes, across[-len(across_axes) :], strict=True):
                panel.plot(x.of(values), SIZE.of(size), ls="", ms=4.5, alpha=0.85, label=name, **look)
        for panel, x in zip(axes[0], across_axes, strict=True):
            panel.set_xlabel(x.label)
            panel.margins(x=0.12)
        axes[0, 0].set_ylim(0.0, 1.08 * axes[0, 0].dataLim.ymax or None)
        axes[0, 0].set_ylabel(SIZE.label)
        style.legend(fig, axes[0, 0], columns=5)
    return fig
