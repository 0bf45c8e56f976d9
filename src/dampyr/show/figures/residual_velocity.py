"""The residual over the velocity: median and quartiles, while the damper speeds up and while it slows down."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import VELOCITY, Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESIDUAL = Axis("residual", "N")
Bands = Mapping[str, tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike]]


def residual_velocity(panels: Mapping[str, Bands], title: str = "") -> Figure:
    """``panels`` name -> branch -> (velocity m/s, lower quartile, median, upper quartile in N), NaN where too few samples."""
    with style.panel_grid(len(panels), 0.6, 1.5, title, most=4, sharey=len(panels) > 2) as (fig, axes, columns):
        for panel, (name, bands) in zip(axes, panels.items(), strict=True):
            _panel(panel, bands)
            panel.set_title(name)
            panel.locator_params(axis="x", nbins=4)
        for panel in axes[::columns]:
            panel.set_ylabel(RESIDUAL.label)
        for panel in axes[-columns:]:
            panel.set_xlabel(VELOCITY.label)
        style.legend(fig, *axes)
    return fig


def _panel(panel: Any, bands: Bands) -> None:
    panel.axhline(0.0, color=style.MUTED, lw=0.8)
    looks = ((style.INK, "-"), (style.MUTED, "--"))  # colours are those of inputs on a page
    for (colour, dash), (name, (velocity, lower, median, upper)) in zip(looks, bands.items(), strict=False):
        v = VELOCITY.of(velocity)
        panel.fill_between(v, RESIDUAL.of(lower), RESIDUAL.of(upper), color=colour, alpha=0.18, lw=0)
        style.line(panel, v, RESIDUAL.of(median), color=colour, ls=dash, lw=1.3, label=name)
