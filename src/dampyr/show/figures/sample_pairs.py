"""Samples of pairs of numbers: a cloud each, with the region that holds 95 % of a normal one, and the estimates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS = 1500  # of a cloud: more only fill it
QUANTILE = 5.991  # of chi-squared with 2 degrees of freedom at 95 %


def sample_pairs(
    samples: Mapping[str, ArrayLike],
    axes: Mapping[str, Axis],
    estimates: Mapping[str, float],
    pairs: Sequence[tuple[str, str]],
    title: str = "",
) -> Figure:
    """``samples`` name -> (n,) SI, their ``axes`` and ``estimates``, and which ``pairs`` to draw, one panel each."""
    columns = min(2, len(pairs))
    rows = math.ceil(len(pairs) / columns)
    fig, panels = style.figure(0.4 + 2.4 * rows, rows, columns, title)
    with style.style():
        for panel, (one, other) in zip(panels.flat, pairs, strict=False):
            x, y = axes[one].of(samples[one]), axes[other].of(samples[other])
            every = max(x.size // DOTS, 1)
            panel.plot(x[::every], y[::every], ".", ms=2, alpha=0.3, color=style.BLUE, label="sample")
            if one != other:
                outline = _ellipse(x, y)
                panel.plot(*outline, color=style.INK, lw=0.9, label="95 % of a normal distribution")
            centre = float(axes[one].of(estimates[one])), float(axes[other].of(estimates[other]))
            panel.plot(*centre, "+", ms=9, mew=1.6, color=style.VERMILLION, ls="", label="fit")
            style.name_axes(panel, axes[one], axes[other])
        for empty in list(panels.flat)[len(pairs) :]:
            empty.set_axis_off()
        style.legend(fig, *panels.flat, columns=3)
    return fig


def _ellipse(x: ArrayLike, y: ArrayLike) -> tuple[ArrayLike, ArrayLike]:
    table = np.stack((np.asarray(x), np.asarray(y)))
    values, vectors = np.linalg.eigh(np.cov(table))
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.stack((np.cos(angle), np.sin(angle)))
    reach = np.sqrt(QUANTILE * np.maximum(values, 0.0))
    along, across = np.mean(table, axis=1)[:, None] + vectors @ (reach[:, None] * circle)
    return along, across
