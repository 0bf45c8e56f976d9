"""A time history, measured and modelled, with what the model leaves below it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures import style
from dampyr.show.figures.style import FORCE, TIME, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def history(
    time: ArrayLike,
    measured: ArrayLike,
    model: ArrayLike | None = None,
    axis: Axis = FORCE,
    name: str = "model",
    title: str = "",
    record_origin: Origin = NOT_STATED,
    share: float = 1.0,
) -> Figure:
    """A quantity over time; with a model also the residual, measured - model, on the same scale.

    Parameters
    ----------
    time
        s, ``(n,)``.
    measured, model
        The quantity as measured and as modelled, SI, ``(n,)``; without a model there is one panel.
    axis
        What the quantity is, and the unit that it is shown in.
    name
        What the line of the model is called.
    title
        Above the figure.
    record_origin
        Origin of what is taken for ``measured``, which says what its line is called.
    share
        How much of the width of a page the figure has.

    Examples
    --------
    >>> import numpy as np
    >>> from dampyr.show.figures.history import history
    >>> time = np.linspace(0.0, 1.0, 200)
    >>> figure = history(time, 90.0 * np.sin(6 * time), 85.0 * np.sin(6 * time), name="Dahl")
    >>> [panel.get_ylabel() for panel in figure.axes]
    ['force [N]', 'residual [N]']
    """
    drawing = (
        style.panels(2.6, title=title, share=share)
        if model is None
        else style.panels(3.2, 2, 1, title, share, sharex=True, height_ratios=(2.4, 1))
    )
    with drawing as (fig, axes):
        top = axes[0, 0]
        style.line(top, time, axis.of(measured), color=style.MEASURED, lw=1.6, label=record_origin.series)
        top.set_ylabel(axis.label)
        if model is not None:
            style.line(top, time, axis.of(model), color=style.VERMILLION, lw=1.1, label=name)
            residual = axis.of(measured) - axis.of(model)
            style.line(axes[1, 0], time, residual, color=style.BLUE, lw=0.9)
            axes[1, 0].set_ylabel(f"residual [{axis.unit}]")
            reach = max(float(np.nanmax(np.abs(residual))), 0.25 * float(np.ptp(axis.of(measured))))
            # not less than a quarter of the quantity's own range: a small residual is to look small
            axes[1, 0].set_ylim(-reach, reach)
        axes[-1, 0].set_xlabel(TIME.label)
        style.legend(fig, top)
    return fig
