"""Fragility curves on a page: figure, numbers, comparisons, and what the cases cannot determine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dampyr.show.figures.fragility import MAX_CURVES, axis_of, fragility_curves
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.structures.fragility import LEVEL, comparisons, curve_table, drawn_curves, limit_in_words
from dampyr.structures.ensembles.fragility import Fragility, FragilityCurve

FEW = " From fewer than 40 motions the band is too narrow away from the median."


def fragility_section(fragility: Fragility, colours: Mapping[str, str] | None = None) -> Section:
    """A section for one limit; ``colours`` of the cases, by their names."""
    caption = (
        f"Lognormal curves of largest likelihood; the band holds {100 * LEVEL:g} % of a bootstrap over the "
        f"{fragility.motions} motions (seed {fragility.seed}); points are the counted shares."
        + " Dashed: not determined by these motions, the text says why."
        * any(c.exists and c.no_band for c in fragility.curves)
        + (FEW if fragility.motions < 40 else "")
    )
    text: list[Block] = [Text("\n\n".join(sentences))] if (sentences := comparisons(fragility)) else []
    return Section(
        f"Fragility: {limit_in_words(fragility)}",
        [*_figures(fragility, caption, colours), curve_table(fragility), *text],
    )


def _figures(fragility: Fragility, caption: str, colours: Mapping[str, str] | None) -> list[Block]:
    axis = axis_of(fragility.intensity)
    parts: list[Sequence[FragilityCurve]] = [
        fragility.curves[k : k + MAX_CURVES] for k in range(0, len(fragility.curves), MAX_CURVES)
    ]
    return [FigureBlock(fragility_curves(drawn_curves(part), axis, colours=colours), caption) for part in parts]
