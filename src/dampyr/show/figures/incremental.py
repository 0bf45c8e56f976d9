"""Incremental curves: intensity against peak for each motion, thin, with the fractiles across them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.fragility import PGA
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_CURVES = 120  # more would cover the fractiles that are drawn over them
DRIFT = Axis("largest drift", "mm", 1e3)
DASHES = ("--", "-", "-.")


def incremental_curves(
    intensity: ArrayLike,
    peaks: ArrayLike,
    levels: ArrayLike,
    fractiles: Mapping[str, ArrayLike],
    axis: Axis = PGA,
    peak: Axis = DRIFT,
    limits: Mapping[str, float] | None = None,
    furthest: float | None = None,
    title: str = "",
    colour: str = style.BLUE,
) -> Figure:
    """Intensity against peak for each motion, of more than `MAX_CURVES` every n-th, with the fractiles across them.

    Parameters
    ----------
    intensity, peaks
        SI, ``(curves, scales)``.
    levels
        The intensities of the fractiles, SI, ``(levels,)``.
    fractiles
        Name -> peaks, SI, ``(levels,)``; infinite where too many cases are without bound.
    axis, peak
        What the intensity and the peak are, and the units that they are shown in.
    limits
        Name -> a peak that is marked, SI.
    furthest
        The peak at which the axis ends, SI, so that figures can be compared; by default it holds all curves.
    title
        Above the figure.
    colour
        Of the fractiles.
    """
    x, y = np.atleast_2d(peaks), np.atleast_2d(intensity)
    with style.single_panel(3.1, title) as (fig, panel):
        for row in range(0, len(x), max(1, -(-len(x) // MAX_CURVES))):
            panel.plot(peak.of(x[row]), axis.of(y[row]), color=style.MUTED, lw=0.5, alpha=0.55)
        for dash, (name, values) in zip(cycle(DASHES), fractiles.items(), strict=False):
            shown = np.where(np.isfinite(values), values, np.nan)
            panel.plot(peak.of(shown), axis.of(levels), dash, color=colour, lw=1.7, label=name)
        for name, value in (limits or {}).items():
            panel.axvline(float(peak.of(value)), color=style.INK, lw=1.1, ls=":", label=name)
        panel.set_xlim(0.0, None if furthest is None else float(peak.of(furthest)))
        panel.set_ylim(bottom=0.0)
        style.name_axes(panel, peak, axis)
        style.legend(fig, panel, columns=5, min_entries=1)
    return fig
