"""The page of an ensemble: peaks in short, fragility curves, incremental curves, and their accuracy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dampyr.phrases import counted
from dampyr.show.figures.fragility import axis_of
from dampyr.show.figures.incremental import incremental_curves
from dampyr.show.figures.style import case_colours
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text, to_look_at
from dampyr.show.pages.fragility_section import fragility_section
from dampyr.show.pages.html_page import page
from dampyr.show.structures.ensemble_result import cases_in_words, peak_table, trust
from dampyr.structures import EnsembleResult, incremental
from dampyr.structures.ensembles.fragility import Fragility
from dampyr.structures.ensembles.incremental import Incremental
from dampyr.structures.ensembles.store import BARE

FRACTIONS = (0.16, 0.5, 0.84)  # the median, and one standard deviation of a normal distribution to each side
MARGIN = 1.2  # how far a figure reaches, in the largest 84 % fractile of all of them


def html(result: EnsembleResult, title: str = "", *, call: str = "") -> str:
    """The page of the result of `dampyr.structures.ensemble`; by default its ``title`` names the buildings."""
    dataset, fragilities = result.dataset, result.curves
    names = ", ".join(str(name) for name in dataset.building_name.values)
    sections = [Section("Peaks", [*to_look_at(result.findings), peak_table(dataset)])]
    swept = dataset.sizes["scale"] > 1 and "drift" in dataset
    analysis = incremental(dataset, "drift", result.intensity, fractions=FRACTIONS) if swept else None
    case_names = [curve.name for fragility in fragilities for curve in fragility.curves]
    case_names += [sweep.name for sweep in analysis.sweeps] if analysis else []
    colours = case_colours(case_names, BARE if BARE in case_names else None)
    sections += [fragility_section(fragility, colours) for fragility in fragilities]
    if analysis:
        sections.append(_incremental_section(analysis, fragilities, colours))
    sections.append(Section("Accuracy", [Text("\n\n".join(trust(dataset)))]))
    return page(
        title or f"Ensemble: {names}",
        sections,
        subtitle=f"{dataset.attrs['cases']} cases: {counted(dataset.sizes['building'], 'building')}, {cases_in_words(dataset)}",
        provenance=_provenance(dataset),
        call=call,
        origin=result.origin,
    )


def _incremental_section(
    analysis: Incremental, fragilities: Sequence[Fragility], colours: Mapping[str, str]
) -> Section:
    axis = axis_of(analysis.intensity)
    limits = {
        f"limit, {1e3 * f.limit:.4g} mm": f.limit for f in fragilities if (f.quantity, f.limit_unit) == ("drift", "m")
    }
    reach = [np.max(s.fractiles[-1], initial=0.0, where=np.isfinite(s.fractiles[-1])) for s in analysis.sweeps]
    furthest = MARGIN * float(max(reach)) or None
    blocks: list[Block] = []
    for s in analysis.sweeps:
        names = {f"{100 * p:g} %": s.fractiles[k] for k, p in enumerate(analysis.fractions)}
        figure = incremental_curves(
            s.intensity, s.peaks, s.levels, names, axis, limits=limits, furthest=furthest, colour=colours[s.name]
        )
        bent = f"{s.bent_back} of {len(s.peaks)} curves bend back somewhere" if s.bent_back else "no curve bends back"
        lost = f"; {s.unbounded} cases grew without bound and are left out of the lines" if s.unbounded else ""
        caption = f"{s.name}: the drift of each motion (grey) and fractiles across motions by intensity; {bent}{lost}."
        blocks.append(FigureBlock(figure, caption))
    return Section("Incremental analysis", blocks)


def _provenance(dataset: Any) -> dict[str, str]:
    scales, attributes = dataset.scale.values, dataset.attrs
    names = [str(name) for name in dataset.motion_name.values]
    shown = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
    span = f"{scales.min():g} to {scales.max():g}" if scales.size > 1 else f"{scales[0]:g}"
    return {
        "motions": shown,
        "scales": f"{scales.size}, {span}",
        "accuracy": f"{attributes['accuracy']}, {attributes['precision_bits']} bits",
    }
