"""The page of an ensemble: peaks in short, fragility curves, incremental curves, and their accuracy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.figures.fragility import axis_of
from dampyr.figures.incremental import incremental_curves
from dampyr.figures.style import case_colours
from dampyr.ground_motions import end_in_words
from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text, to_look_at
from dampyr.report.fragility_section import fragility_section
from dampyr.report.html_page import page, write_page
from dampyr.structures import EnsembleResult, Fragility, Incremental, incremental, summary
from dampyr.structures.ensembles.ensemble_accuracy import BOUNDS, FLOOR, truncation_in_words
from dampyr.structures.time_history.simulate import BARE

SHOWN = {
    "drift": ("drift", "mm", 1e3),
    "displacement": ("displacement", "mm", 1e3),
    "acceleration": ("acceleration", "m/s²", 1.0),
    "force": ("damper force", "N", 1.0),
}
FRACTIONS = (0.16, 0.5, 0.84)  # the median, and one standard deviation of a normal distribution to each side
MARGIN = 1.2  # how far a figure reaches, in the largest 84 % fractile of all of them


def write_ensemble_page(
    dataset: Any, path: str | Path, fragilities: Sequence[Fragility] = (), intensity: str = "pga", title: str = ""
) -> Path:
    """Write the page of the result of `dampyr.structures.run_ensemble`.

    In place of a result, a dataset of `ensemble` or `read_ensemble` with its ``fragilities``, in the order of their figures,
    will do.
    """
    if isinstance(dataset, EnsembleResult):
        dataset, fragilities, intensity = dataset.dataset, dataset.curves, dataset.intensity
    result = EnsembleResult(dataset, tuple(fragilities), intensity)
    names = ", ".join(str(name) for name in dataset.building_name.values)
    sections = [Section("Peaks", [*to_look_at(result.findings), *summary_tables(dataset)])]
    swept = dataset.sizes["scale"] > 1 and "drift" in dataset
    analysis = incremental(dataset, "drift", intensity, fractions=FRACTIONS) if swept else None
    case_names = [curve.name for fragility in fragilities for curve in fragility.curves]
    case_names += [sweep.name for sweep in analysis.sweeps] if analysis else []
    colours = case_colours(case_names, BARE if BARE in case_names else None)
    sections += [fragility_section(fragility, colours) for fragility in fragilities]
    if analysis:
        sections.append(_incremental_section(analysis, fragilities, colours))
    sections.append(Section("Accuracy", [Text("\n\n".join(trust(dataset)))]))
    html = page(
        title or f"Ensemble: {names}",
        sections,
        subtitle=_sizes(dataset),
        provenance=_provenance(dataset),
        call=f"dampyr.report.write_ensemble_page(result, {Path(path).name!r})",
        origin=result.origin,
    )
    return write_page(path, html)


def _sizes(dataset: Any) -> str:
    n = dataset.sizes
    parts = [(n["building"], "building"), (n["damper"], "damper case"), (n["input"], "input"), (n["motion"], "motion"),
             (n["scale"], "scale")]  # fmt: skip
    words = [f"{count} {word}{'s' * (count != 1)}" for count, word in parts]
    return f"{dataset.attrs['cases']} cases: {', '.join(words)}"


def summary_rows(dataset: Any, shown: Sequence[str] = tuple(SHOWN)) -> tuple[list[str], list[str], list[list[Cell]]]:
    """Columns, units and rows of medians and 84 % fractiles, worst storey, floor and damper."""
    quantities = [q for q in shown if q in dataset and dataset[q].shape[-1]]
    columns = ["case", "scale"] + [f"{SHOWN[q][0]}, {part}" for q in quantities for part in ("median", "84 %")]
    units = ["", ""] + [SHOWN[q][1] for q in quantities for _ in range(2)]
    rows: list[list[Cell]] = []
    for row in summary(dataset):
        pairs = [(row.peaks[q] or (None, None), SHOWN[q][2]) for q in quantities]
        numbers = [None if v is None else factor * v for pair, factor in pairs for v in pair]
        rows.append([row.name, row.scale, *numbers])
    return columns, units, rows


def summary_tables(dataset: Any) -> list[Table]:
    """The summary: what moves, and what is felt."""
    captions = {
        (
            "drift",
            "displacement",
        ): "Across motions and draws of the damper, of the worst storey and floor of each case; "
        "displacements relative to the ground.",
        ("acceleration", "force"): "The same for absolute accelerations and the dampers' forces.",
    }
    made = [(caption, summary_rows(dataset, shown)) for shown, caption in captions.items()]
    return [Table(c, rows, units, caption=caption, digits=4) for caption, (c, units, rows) in made if len(c) > 2]


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
        blocks.append(FigureBlock(figure, _sweep_in_words(s)))
    return Section("Incremental analysis", blocks)


def _sweep_in_words(s: Any) -> str:
    bent = f"{s.bent_back} of {len(s.peaks)} curves bend back somewhere" if s.bent_back else "no curve bends back"
    lost = f"; {s.unbounded} cases grew without bound and are left out of the lines" if s.unbounded else ""
    return f"{s.name}: the drift of each motion (grey) and fractiles across motions by intensity; {bent}{lost}."


def trust(dataset: Any) -> list[str]:
    """What was measured of the error, and what it does not cover; sentences."""
    attributes = dataset.attrs
    error = f"{100 * attributes['error_estimate']:.2g} %"
    moving = attributes.get("error_estimate_moving")
    among = f" ({100 * moving:.2g} % among {FLOOR})" if moving is not None else ""
    measured = (
        f"The largest change of a peak displacement or drift on halving the step was {error}{among}, measured on "
        f"{attributes['judged']} of {attributes['cases']} cases, the hardest and others at random."
    )
    bound = f"{100 * BOUNDS[attributes['accuracy']]:.2g} %"
    fast = (
        f"The accuracy is “fast”: about 0.1 % of the peak in strong motion, at most {bound} of {FLOOR}; smaller ones have no "
        "bound. Accelerations are less sharp, a few per cent at a high input, rarely ten. Accuracy “strict” takes 0.4 of the "
        "step."
    )
    strict = f"The accuracy is “strict”: at most {bound} of {FLOOR}; smaller ones have no bound. Accelerations are less sharp."
    lost = [] if attributes["unbounded"] else ["No case grew without bound."]
    end = f"Each case {end_in_words(attributes.get('after_s', 0.0))}."
    left_out = truncation_in_words(attributes)
    reduced = [f"{left_out[0].upper()}{left_out[1:]}."] if left_out else []
    return [measured, fast if attributes["accuracy"] == "fast" else strict, *reduced, end, *lost]


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
