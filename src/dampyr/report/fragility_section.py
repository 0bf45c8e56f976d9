"""Fragility curves on a page: figure, numbers, comparisons, and what the cases cannot determine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from dampyr.figures.fragility import MAX_CURVES, axis_of, fragility_curves
from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text
from dampyr.representation import sentence
from dampyr.structures import Curve, Fragility
from dampyr.structures.ensembles.fragility import LEVEL, drawn_curves

COLUMNS = ("case", "median", "from", "to", "beta", "direct median", "direct beta", "cases", "exceed", "without bound")
FEW = " From fewer than 40 motions the band is too narrow away from the median."
DIRECT = (
    "Direct: from the intensity at which each motion first exceeds the limit, linear between its scales; motions that never "
    "exceed it, or do so at the weakest scale already, enter the likelihood as censored."
)


def fragility_rows(fragility: Fragility) -> list[list[Cell]]:
    """One row for each curve, in the order of `COLUMNS`; None where there is no number."""
    axis = axis_of(fragility.intensity)
    rows: list[list[Cell]] = []
    for c in fragility.curves:
        numbers = [float(axis.of(v)) for v in (c.theta, *c.theta_band(LEVEL))]
        direct = [float(axis.of(c.direct.theta)), c.direct.beta]
        cells: list[Cell] = [None if np.isnan(v) else float(v) for v in (*numbers, c.beta, *direct)]
        rows.append([c.name, *cells, int(c.of.sum()), int(c.exceeding.sum()), c.unbounded])
    return rows


def fragility_units(fragility: Fragility) -> list[str]:
    """Units of the columns."""
    unit = axis_of(fragility.intensity).unit
    return ["", unit, unit, unit, "", unit, "", "", "", ""]


def remarks(fragility: Fragility) -> list[str]:
    """What the cases cannot determine, and how curves compare."""
    notes = [f"{c.name}: no curve; {c.reason}" for c in fragility.curves if not c.exists]
    notes += [f"{c.name}: no band; {c.no_band}" for c in fragility.curves if c.exists and c.no_band]
    notes += [
        f"{c.name}: no direct estimate; {c.direct.reason}" for c in fragility.curves if c.exists and c.direct.reason
    ]
    notes += [_censored(c) for c in fragility.curves if c.capacities.above or c.capacities.below]
    first = fragility.curves[0]
    for c in fragility.curves[1:]:
        if first.exists and c.exists:
            ratio, low, high = fragility.ratio(c.name, first.name, LEVEL)
            band = "" if np.isnan(low) else f" (90 % band {low:.3g} to {high:.3g})"
            notes.append(f"{c.name}: its median is {ratio:.3g} times that of {first.name}{band}")
    return notes


def _censored(c: Curve) -> str:
    held, all_ = c.capacities, c.capacities.value.size
    parts = [f"{held.above} never exceed the limit"] * bool(held.above)
    parts += [f"{held.below} do at the weakest scale already"] * bool(held.below)
    return f"{c.name}: of {all_} sweeps {' and '.join(parts)}"


def fragility_section(fragility: Fragility, colours: Mapping[str, str] | None = None) -> Section:
    """A section for one limit; ``colours`` of the cases, by their names."""
    caption = (
        f"Lognormal curves of largest likelihood; the band holds {100 * LEVEL:g} % of a bootstrap over the "
        f"{fragility.motions} motions (seed {fragility.seed}); points are the counted shares."
        + (FEW if fragility.motions < 40 else "")
    )
    table = Table(
        COLUMNS,
        fragility_rows(fragility),
        fragility_units(fragility),
        caption=f"Median with its {100 * LEVEL:g} % band, and beta, the standard deviation of the logarithm. {DIRECT}",
        digits=4,
    )
    notes = "\n\n".join(sentence(each) for each in remarks(fragility))
    text: list[Block] = [Text(notes)] if notes else []
    return Section(f"Fragility: {fragility.limit_in_words}", [*_figures(fragility, caption, colours), table, *text])


def _figures(fragility: Fragility, caption: str, colours: Mapping[str, str] | None) -> list[Block]:
    axis = axis_of(fragility.intensity)
    parts: list[Sequence[Curve]] = [
        fragility.curves[k : k + MAX_CURVES] for k in range(0, len(fragility.curves), MAX_CURVES)
    ]
    return [FigureBlock(fragility_curves(drawn_curves(part), axis, colours=colours), caption) for part in parts]
