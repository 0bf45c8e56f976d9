"""What a rig can do in the plane of frequency and amplitude, at several forces, and the tests of a plan in it."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FREQUENCY = Axis("frequency", "Hz")
AMPLITUDE = Axis("amplitude", "mm", 1e3)
MARKERS = "osD^v*P"
NESTED = 4  # sizes of markers, so that tests of one place lie around one another and are all seen


def envelope(
    frequency: ArrayLike,
    limits: Mapping[str, ArrayLike],
    tests: Mapping[str, tuple[ArrayLike, ArrayLike]],
    refused: tuple[ArrayLike, ArrayLike] = ((), ()),
    title: str = "",
    colours: Mapping[str, str] | None = None,
) -> Figure:
    """Tests in the plane of frequency and amplitude; both axes are logarithmic, so lines of equal speed are straight.

    Parameters
    ----------
    frequency
        Hz, ``(n,)``.
    limits
        Name, such as a force -> the largest amplitude of a sine, m, ``(n,)``.
    tests
        Name of a group -> frequencies Hz and amplitudes m of its tests.
    refused
        Frequencies Hz and amplitudes m of tests that are crossed out.
    title
        Above the figure.
    colours
        Name of a group -> colour.
    """
    f = FREQUENCY.of(frequency)
    with style.single_panel(3.6, title) as (fig, panel):
        for strength, (name, values) in zip(np.linspace(1.0, 0.45, len(limits)), limits.items(), strict=True):
            panel.plot(f, AMPLITUDE.of(values), color=style.MUTED, lw=1.4 * strength + 0.2, alpha=strength)
            last = float(AMPLITUDE.of(values)[-1])
            panel.annotate(
                name, (f[-1], last), (3, 0), textcoords="offset points", fontsize=8, color=style.MUTED, va="center"
            )
        colours = colours or style.case_colours(tests)
        for k, (marker, (name, (x, y))) in enumerate(zip(cycle(MARKERS), tests.items(), strict=False)):
            look = {"ms": 4.5 + 2.5 * (k % NESTED), "mfc": "none", "mew": 1.3, "color": colours[name]}
            panel.plot(FREQUENCY.of(x), AMPLITUDE.of(y), marker, label=name, **look)
        if np.size(refused[0]):
            panel.plot(FREQUENCY.of(refused[0]), AMPLITUDE.of(refused[1]), "x", ms=8, color=style.INK, label="refused")
        style.logarithmic(panel)
        panel.set_xlim(f[0], f[-1])
        style.name_axes(panel, FREQUENCY, AMPLITUDE)
        style.legend(fig, panel, columns=4, min_entries=1)
    return fig
