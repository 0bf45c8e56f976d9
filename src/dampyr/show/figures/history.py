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
) -> Figure:
    """A quantity over time; with a model also the residual, measured - model, on the same scale.

    ``time`` s, ``measured`` and ``model`` in SI ``(n,)``; ``axis`` says what they are, ``record_origin`` what is taken for
    ``measured``.
    """
    if model is None:
        fig, axes = style.figure(2.6, 1, 1, title)
    else:
        fig, axes = style.figure(3.4, 2, 1, title, sharex=True, height_ratios=(2.4, 1))
    with style.style():
        top = axes[0, 0]
        style.line(top, time, axis.of(measured), color=style.MEASURED, lw=1.6, label=record_origin.series)
        top.set_ylabel(axis.label)
        if model is not None:
            style.line(top, time, axis.of(model), color=style.VERMILLION, lw=1.1, label=name)
            left = axis.of(measured) - axis.of(model)
            style.line(axes[1, 0], time, left, color=style.BLUE, lw=0.9)
            axes[1, 0].set_ylabel(f"residual [{axis.unit}]")
            reach = max(float(np.nanmax(np.abs(left))), 0.25 * float(np.ptp(axis.of(measured))))
            axes[1, 0].set_ylim(-reach, reach)
        axes[-1, 0].set_xlabel(TIME.label)
        style.legend(fig, top)
    return fig
