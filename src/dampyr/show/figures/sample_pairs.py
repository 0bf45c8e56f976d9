"""Samples of pairs of numbers: a cloud each, with the region that holds 95 % of a normal one, and the estimates."""

from __future__ import annotations

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
    with style.panel_grid(len(pairs), 0.4, 2.4, title) as (fig, panels, _):
        for panel, (across, up) in zip(panels, pairs, strict=True):
            x, y = axes[across].of(samples[across]), axes[up].of(samples[up])
            every = max(x.size // DOTS, 1)
            panel.plot(x[::every], y[::every], ".", ms=2, alpha=0.3, color=style.BLUE, label="sample")
            if across != up:
                outline = ellipse(x, y)
                panel.plot(*outline, color=style.INK, lw=0.9, label="95 % of a normal distribution")
            centre = float(axes[across].of(estimates[across])), float(axes[up].of(estimates[up]))
            panel.plot(*centre, "+", ms=9, mew=1.6, color=style.VERMILLION, ls="", label="fit")
            style.name_axes(panel, axes[across], axes[up])
        style.legend(fig, *panels)
    return fig


def ellipse(x: ArrayLike, y: ArrayLike) -> tuple[ArrayLike, ArrayLike]:
    """The line ``(181,)``, ``(181,)`` inside of which 95 % of a normal distribution with the covariance of these lie."""
    table = np.stack((np.asarray(x), np.asarray(y)))
    values, vectors = np.linalg.eigh(np.cov(table))
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.stack((np.cos(angle), np.sin(angle)))
    # a point of the unit circle, stretched along the axes of the covariance: Mahalanobis's distance is the same all round
    reach = np.sqrt(QUANTILE * np.maximum(values, 0.0))
    along, across = np.mean(table, axis=1)[:, None] + vectors @ (reach[:, None] * circle)
    return along, across
