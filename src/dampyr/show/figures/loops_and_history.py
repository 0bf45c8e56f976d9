"""One record and its model on one strip: loops over displacement and velocity, and the force over time with its residual."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dampyr.origin import NOT_STATED, Origin
from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, FORCE, TIME, VELOCITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
LAYOUT = [["displacement", "velocity", "time"], ["displacement", "velocity", "residual"]]


def loops_and_history(
    t: Array,
    x: Array,
    v: Array,
    measured: Array,
    model: Array,
    seconds: float,
    name: str = "model",
    record_origin: Origin = NOT_STATED,
) -> Figure:
    """Loops of the whole record, and its first ``seconds`` over time with the residual, measured less modelled, below.

    Parameters
    ----------
    t, x, v
        Time s, displacement m and velocity m/s, ``(n,)``.
    measured, model
        The force as measured and as modelled, N, ``(n,)``.
    seconds
        How much of it is shown over time.
    name
        What the line of the model is called.
    record_origin
        Origin of what is taken for ``measured``, which says what its line is called.

    Examples
    --------
    >>> import numpy as np
    >>> from dampyr.show.figures.loops_and_history import loops_and_history
    >>> t = np.linspace(0.0, 4.0, 400)
    >>> x, v = 0.01 * np.sin(6 * t), 0.06 * np.cos(6 * t)
    >>> figure = loops_and_history(t, x, v, 1500.0 * v, 1400.0 * v, 2.0, "Dahl")
    >>> [panel.get_xlabel() for panel in figure.axes]
    ['displacement [mm]', 'velocity [mm/s]', '', 'time [s]']
    """
    ratios = {"width_ratios": (1.2, 1.2, 1.5), "height_ratios": (2.2, 1)}
    with style.panel_mosaic(2.35, LAYOUT, **ratios) as (fig, panels):
        early = t <= t[0] + seconds
        for key, over, axis in (("displacement", x, DISPLACEMENT), ("velocity", v, VELOCITY)):
            style.line(panels[key], axis.of(over), FORCE.of(measured), color=style.MEASURED, lw=1.2)
            panels[key].plot(*style.thin(axis.of(over), FORCE.of(model)), color=style.VERMILLION, lw=1.0)
            panels[key].set_xlabel(axis.label)
            panels[key].locator_params(axis="x", nbins=3)
            panels[key].tick_params(axis="x", labelsize=8)
            panels[key].sharey(panels["time"])
        panels["displacement"].set_ylabel(FORCE.label)
        top, rest = panels["time"], panels["residual"]
        series = record_origin.series
        style.line(top, t[early], FORCE.of(measured[early]), color=style.MEASURED, lw=1.6, label=series)
        style.line(top, t[early], FORCE.of(model[early]), color=style.VERMILLION, lw=1.1, label=name)
        residual = FORCE.of(measured - model)[early]
        style.line(rest, t[early], residual, color=style.BLUE, lw=0.9)
        # not less than a quarter of the force's own range: a small residual is to look small
        reach = max(float(np.nanmax(np.abs(residual))), 0.25 * float(np.ptp(FORCE.of(measured))))
        rest.set_ylim(-reach, reach)
        rest.sharex(top)
        top.tick_params(labelbottom=False)
        rest.set_ylabel("residual\n[N]")
        rest.set_xlabel(TIME.label)
        style.legend(fig, top)
    return fig
