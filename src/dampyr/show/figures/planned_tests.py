"""Candidate and chosen tests in the plane of frequency and amplitude, with the largest sine that a rig can do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.envelope import AMPLITUDE, FREQUENCY, MARKERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def planned_tests(
    frequency: ArrayLike,
    limits: Mapping[str, ArrayLike],
    candidates: Sequence[tuple[float, float]],
    chosen: Mapping[str, Sequence[tuple[float, float]]],
    title: str = "",
) -> Figure:
    """``frequency`` (n,) Hz; ``limits`` name -> the largest amplitude (n,) m; ``candidates`` and the ``chosen`` of each kind
    are pairs of frequency Hz and amplitude m; of one that was chosen more than once the number stands beside it.
    """
    f = FREQUENCY.of(frequency)
    colours = style.case_colours(chosen)
    with style.single_panel(3.6, title) as (fig, panel):
        for strength, values in zip(np.linspace(1.0, 0.45, len(limits)), limits.values(), strict=True):
            panel.plot(f, AMPLITUDE.of(values), color=style.MUTED, lw=1.4 * strength + 0.2, alpha=strength, zorder=1)
        names = [*limits]
        if names:
            label = f"largest sine, {names[0]}" + (f" (top) to {names[-1]}" if len(names) > 1 else "")
            panel.plot([], [], color=style.MUTED, lw=1.4, label=label)
        candidate_places = np.array(candidates, dtype=float).reshape(-1, 2)
        x, y = FREQUENCY.of(candidate_places[:, 0]), AMPLITUDE.of(candidate_places[:, 1])
        panel.plot(x, y, ".", ms=4, color=style.MUTED, label="candidates")
        for marker, (name, points) in zip(cycle(MARKERS), chosen.items(), strict=False):
            places, counts = np.unique(np.array(points, dtype=float).reshape(-1, 2), axis=0, return_counts=True)
            x, y = FREQUENCY.of(places[:, 0]), AMPLITUDE.of(places[:, 1])
            panel.plot(x, y, marker, ms=9, mfc="none", mew=1.6, color=colours[name], label=f"chosen: {name}", ls="none")
            for a, b, count in zip(x, y, counts, strict=True):
                if count > 1:
                    panel.annotate(
                        f"{count}", (a, b), (7, 4), textcoords="offset points", fontsize=8, color=colours[name]
                    )
        style.logarithmic(panel)
        style.name_axes(panel, FREQUENCY, AMPLITUDE)
        style.legend(fig, panel, columns=2, min_entries=1)
    return fig
