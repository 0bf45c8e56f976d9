"""Loads on floors over time: the largest ones, a panel each, with the peak marked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import TIME, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LARGE = 1e4  # N, from which on forces are drawn in kN
DRAWN = 4  # floors: of more, those with the largest peaks


def floor_loads(time: ArrayLike, forces: Mapping[str, ArrayLike], title: str = "") -> Figure:
    """``time`` s, ``(n,)``, and ``forces``, floor -> N, ``(n,)``: the `DRAWN` floors with the largest peaks, the last on top.

    >>> import numpy as np
    >>> from dampyr.show.figures.floor_loads import floor_loads
    >>> len(floor_loads(np.array([0.0, 1.0, 2.0]), {"1": np.zeros(3), "2": np.array([0.0, 9.0, 0.0])}).axes)
    2
    """
    peaks = {floor: float(np.max(np.abs(np.asarray(row)))) for floor, row in forces.items()}
    largest = sorted(peaks, key=lambda floor: -peaks[floor])[:DRAWN]
    drawn = [floor for floor in forces if floor in largest][::-1]
    axis = Axis("load", "kN", 1e-3) if max(peaks.values()) >= LARGE else Axis("load", "N")
    t = TIME.of(time)
    with style.panels(1.2 + 1.1 * len(drawn), len(drawn), 1, title, sharex=True, sharey=True) as (fig, axes):
        for panel, floor in zip(axes[:, 0], drawn, strict=True):
            name = f"floor {floor}" if floor.isdigit() else floor
            style.line_with_peak(panel, time, forces[floor], axis, name, style.BLUE)
        fig.supylabel(axis.label, fontsize=10)
        axes[-1, 0].set_xlim(t[0], t[-1])
        axes[-1, 0].set_xlabel(TIME.label)
        style.legend(fig, *axes[:, 0], columns=2, min_entries=1)
    return fig
