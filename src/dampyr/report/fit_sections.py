"""Tables and figures of a fit that several pages share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dampyr.figures.correlation import MARKED, correlation, strong_pairs
from dampyr.figures.laws import parameters_against_input
from dampyr.figures.scores import scores as scores_by_input
from dampyr.figures.style import CURRENT, VOLTAGE
from dampyr.identification import Fit, Score
from dampyr.identification.fits.law_panels import law_panels
from dampyr.identification.scoring.score import group_by_input
from dampyr.report.blocks import Block, Cell, FigureBlock, Table, Text

PANELS = 6  # of laws in one figure: three rows of two, half of a printed page
PAIRS = 8  # of parameters listed in words; the matrix shows all

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from dampyr.models import Damper


def parameter_tables(fit: Fit) -> list[Table]:
    """Every fitted number with half of its 95 % interval, and its standard error with the naive one: a row a parameter, a
    column an input, in units that people read.

    Errors that hold within the fitted records only say so: these numbers have no interval.
    """
    tables = []
    wanted = [(False, "records", "Value ± half of its 95 % interval."), (True, "records", _caption(fit))]
    if fit.levels is not None:
        level = f"whose level differs by {fit.levels.spread_words}"
        wanted.insert(1, (False, "sessions", f"The same between measurement sessions, {level}."))
    for errors, between, caption in wanted:
        heads, rows = fit.by_input(errors, between)
        align = ("left", "left", *("right",) * (len(heads) - 2))
        tables.append(Table(columns=tuple(heads), rows=rows, align=align, caption=caption))
    return tables


def _caption(fit: Fit) -> str:
    within = "each cycle: they hold within these records only, say nothing of how records differ, and give no interval"
    between = "each record, and intervals take Student's t with the effective number of these"
    correlated = {
        "record": between,
        "cycle": within,
        "record and cycle": f"{between}; where so labelled, within {within}",
    }
    return (
        "Standard errors, and in parentheses the naive ones. "
        f"Errors allow for residuals that are correlated within {correlated[fit.clusters]}. The naive errors assume "
        "independent samples and are shown for comparison."
    )


def correlation_blocks(fit: Fit) -> list[Block]:
    """The correlations of the fitted numbers: the matrix, and the strong pairs in words."""
    names = list(fit.parameters)
    if len(names) < 2:
        return [Text(f"There is one parameter, {names[0]}, so there are no correlations.")]
    return [
        Text(_correlations_in_words(fit.correlation, names)),
        FigureBlock(
            correlation(fit.correlation, names),
            "Correlations of the errors (the covariance, scaled by the standard errors): rows by name, columns by the rows' "
            "numbers. Blue: positive, both errors have one sign; orange: negative, one compensates the other.",
        ),
    ]


def _correlations_in_words(correlations: NDArray[np.float64], names: list[str]) -> str:
    """The strong pairs, else the strongest one, and which parameters have no correlations."""
    pairs = strong_pairs(correlations, names, 0.0)
    words = [f"{one} and {other} ({r:.2f})".replace("(-", "(−") for one, other, r in pairs]
    strong = sum(abs(r) > MARKED for _, _, r in pairs)
    if strong:
        more = f"; and {strong - PAIRS} pairs more" if strong > PAIRS else ""
        text = (
            f"Correlated beyond ±{MARKED:g}: {'; '.join(words[: min(strong, PAIRS)])}{more}. The records determine only a "
            "combination of each pair, so change or compare them together, never one alone."
        )
    else:
        strongest = f"; the strongest are {words[0]}" if words else ""
        text = f"No two parameters are correlated beyond ±{MARKED:g}{strongest}."
    unknown = [name for name, r in zip(names, np.diag(correlations), strict=True) if not np.isfinite(r)]
    return text + (f"\n\nNothing is known of how {', '.join(unknown)} would go with the others." if unknown else "")


def law_figures(fit: Fit, damper: Damper) -> list[Figure]:
    """Each parameter over the input: the law, the fitted values with 95 % intervals, the calibrated range.

    No figure is so high that it would fill a printed page by itself.
    """
    panels = law_panels(fit.optimum, fit.intervals(), damper)
    axis = VOLTAGE if damper.input == "V" else CURRENT
    count = -(-len(panels) // PANELS)
    each = -(-len(panels) // count)
    each += each % 2 if count > 1 else 0
    parts = [panels[k : k + each] for k in range(0, len(panels), each)]
    return [parameters_against_input(part, damper.range, axis) for part in parts]


def score_table(
    scores: Mapping[str, Score], caption: str, more: Mapping[str, tuple[str, Mapping[str, Cell]]] | None = None
) -> Table:
    """One row per record, ratios in percent; ``more`` name -> (unit, cell of each record) are further columns before them."""
    more = more or {}
    rows: list[list[Cell]] = [
        [
            name,
            *(cells[name] for _, cells in more.values()),
            100 * s.l1,
            100 * s.nrmse,
            s.r2,
            100 * s.pointwise,
            100 * s.peak_force,
            100 * s.energy,
            s.offset,
        ]
        for name, s in scores.items()
    ]
    return Table(
        columns=("record", *more, "L1", "NRMSE", "R²", "pointwise", "peak force", "energy", "offset"),
        units=("", *(unit for unit, _ in more.values()), "%", "%", "", "%", "%", "%", "N"),
        rows=rows,
        caption=caption,
        digits=3,
    )


def score_blocks(fit: Fit) -> list[Block]:
    """How well a fit describes the records that it was fitted to."""
    table = score_table(fit.scores, f"From {fit.settling:g} s after the motion starts, each record's own offset taken.")
    groups = group_by_input(fit.records, {name: one.l1 for name, one in fit.scores.items()})
    if len(fit.records) == 1:
        return [Text("This record was fitted: the score describes the fit and is no prediction."), table]
    return [
        Text("These records were fitted: the scores describe the fit and are not predictions."),
        FigureBlock(scores_by_input(groups), "L1 ratio of each record, by input."),
        table,
    ]


def fit_blocks(fit: Fit) -> list[Block]:
    """Parameters and laws."""
    blocks: list[Block] = [*parameter_tables(fit)]
    if fit.damper is not None and fit.damper.range[0] < fit.damper.range[1]:
        bars = "fitted values" if fit.clusters == "cycle" else "fitted values with 95 % intervals"
        some = " (none where an error holds within these records only)" if fit.clusters == "record and cycle" else ""
        caption = f"Parameters over the input: {bars}{some}, the laws through them, the calibrated range."
        blocks += [FigureBlock(figure, caption) for figure in law_figures(fit, fit.damper)]
    return blocks
