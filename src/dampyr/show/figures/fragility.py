"""Fragility curves: how likely a limit is exceeded over the intensity, with bands and what was counted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from dampyr.phrases import extent
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.style import Axis
from dampyr.shown import Shown
from dampyr.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PGA = Axis("peak ground acceleration", "g", 1 / STANDARD_GRAVITY)
SA = Axis("Sa at the first period, 5 %", "g", 1 / STANDARD_GRAVITY)
SCALE = Axis("scale of the motions", "1")
PROBABILITY = Axis("probability of exceeding", "%", 100.0)


MAX_CURVES = len(style.SERIES)  # in one figure: as many as there are colours


def axis_of(intensity: str) -> Axis:
    """How an intensity is shown: "pga", "sa" or "scale", else a measure of the reader's own."""
    return {"pga": PGA, "sa": SA, "scale": SCALE}.get(intensity, Axis("intensity, your measure", "its unit"))


@dataclass(frozen=True, repr=False)
class Fragile(Shown):
    """One curve: ``probability`` over ``intensity`` SI (n,), None without a curve; ``band`` (low, high); ``counted``
    (intensity, share), shown as points. A curve that the cases do not ``determine`` is dashed."""

    intensity: ArrayLike
    probability: ArrayLike | None
    band: tuple[ArrayLike, ArrayLike] | None = None
    counted: tuple[ArrayLike, ArrayLike] | None = None
    determined: bool = True


@describe.register
def describe_fragile(curve: Fragile) -> Description:
    """Intensities, the curve, its band and the levels that were counted; the curve by itself."""
    levels = 0 if curve.counted is None else np.size(curve.counted[0])
    return Description(
        "Fragile",
        [
            ("intensity", f"{np.size(curve.intensity)} values, {extent(curve.intensity, '')} (SI)"),
            ("curve", "none" if curve.probability is None else extent(curve.probability, "")),
            ("band", "none" if curve.band is None else "a lower and an upper edge"),
            ("counted", f"{levels} levels"),
        ],
        figure=lambda: fragility_curves({"curve": curve}),
    )


def fragility_curves(
    curves: Mapping[str, Fragile], axis: Axis = PGA, title: str = "", colours: Mapping[str, str] | None = None
) -> Figure:
    """All curves in one panel; at most six, one colour each, those of ``colours`` (name -> colour) where it is given."""
    with style.single_panel(3.3, title) as (fig, panel):
        colours = colours or style.case_colours(curves)
        for name, curve in curves.items():
            _draw(panel, name, curve, axis, colours[name])
        panel.set_ylim(-2, 102)
        panel.set_xlim(left=0.0)
        style.name_axes(panel, axis, PROBABILITY)
        style.legend(fig, panel, columns=4, min_entries=1)
    return fig


def _draw(panel: Any, name: str, curve: Fragile, axis: Axis, colour: str) -> None:
    x = axis.of(curve.intensity)
    label: str | None = name  # once: of the curve, else of the points
    if curve.band is not None and not np.isnan(np.asarray(curve.band[0], dtype=float)).all():
        panel.fill_between(x, *(PROBABILITY.of(edge) for edge in curve.band), color=colour, alpha=0.16, lw=0)
    if curve.probability is not None:
        dash = "-" if curve.determined else "--"
        panel.plot(x, PROBABILITY.of(curve.probability), color=colour, lw=1.4, ls=dash, label=label)
        label = None
    if curve.counted is not None:
        intensity, share = curve.counted
        panel.plot(axis.of(intensity), PROBABILITY.of(share), "o", ms=3, color=colour, alpha=0.75, mew=0, label=label)
