r"""The function theta of the limit-cycle method, :math:`\theta(x) = k_w \bar w = \bar F - k_x \dot x`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dampyr.show.figures import style
from dampyr.show.figures.style import DISPLACEMENT, FORCE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def theta(
    displacement: ArrayLike,
    values: ArrayLike,
    marks: Mapping[str, tuple[float, float]] | None = None,
    exact: tuple[ArrayLike, ArrayLike] | None = None,
    title: str = "",
    share: float = 1.0,
) -> Figure:
    """``displacement`` m and theta N on the rising branch ``(n,)``.

    ``marks`` name -> (m, N) are the points chosen on it (where theta is zero, and the second one); ``exact``
    (m, N) is a closed form to compare with. ``share``: of the page's width.
    """
    with style.single_panel(2.6, title, share) as (fig, panel):
        style.line(panel, DISPLACEMENT.of(displacement), FORCE.of(values), color=style.BLUE, label="θ")
        if exact is not None:
            x, y = DISPLACEMENT.of(exact[0]), FORCE.of(exact[1])
            style.line(panel, x, y, color=style.MUTED, ls="--", label="closed form")
        colours = (style.VERMILLION, style.GREEN, style.PURPLE, style.ORANGE)
        for colour, (name, (place, force)) in zip(cycle(colours), (marks or {}).items(), strict=False):
            panel.plot(DISPLACEMENT.of(place), FORCE.of(force), "o", ms=6, color=colour, label=name)
        panel.set_xlabel(DISPLACEMENT.label)
        panel.set_ylabel("θ [N]")
        style.legend(fig, panel)
    return fig
