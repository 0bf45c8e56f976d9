"""Tables and figures of a fit that several pages share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from dampyr.identification import Fit
from dampyr.input_kinds import INPUTS
from dampyr.show.figures.correlation import MARKED, correlation, strong_pairs
from dampyr.show.figures.laws import parameters_against_input
from dampyr.show.figures.scores import scores as scores_by_input
from dampyr.show.figures.style import input_axis
from dampyr.show.identification.law_panels import law_panels
from dampyr.show.identification.result import error_table, parameter_table, session_table
from dampyr.show.identification.score import group_by_input
from dampyr.show.identification.validation import score_table
from dampyr.show.pages.blocks import Block, FigureBlock, Text
from dampyr.show.pages.residual_section import size_table
from dampyr.show.table import Table

PANELS = 9  # of laws in one figure: three rows of three, half of a printed page
PAIRS = 8  # of parameters listed in words; the matrix shows all

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from dampyr.models import Damper


def parameter_tables(fit: Fit) -> list[Table]:
    """Values with half of their 95 % intervals, the same between sessions where the fit has levels, and the standard errors."""
    return [parameter_table(fit), *error_tables(fit)]


def error_tables(fit: Fit) -> list[Table]:
    """The intervals between measurement sessions where the fit has levels, and the standard errors with what they allow for."""
    errors = error_table(fit)
    errors = replace(errors, caption=f"{errors.caption} {_allowed_for(fit)}")
    return [errors] if fit.levels is None else [session_table(fit), errors]


def _allowed_for(fit: Fit) -> str:
    within = "each cycle: they hold within these records only, say nothing of how records differ, and give no interval"
    between = "each record, and intervals take Student's t with the effective number of these"
    correlated = {
        "record": between,
        "cycle": within,
        "record and cycle": f"{between}; where so labelled, within {within}",
    }
    return (
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
    words = [f"{first} and {second} ({r:.2f})".replace("(-", "(−") for first, second, r in pairs]
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
    axis = input_axis(damper.input)
    count = -(-len(panels) // PANELS)
    size = -(-len(panels) // count)
    size += -size % 3 if count > 1 else 0  # rows of three are filled
    parts = [panels[k : k + size] for k in range(0, len(panels), size)]
    return [parameters_against_input(part, damper.range, axis) for part in parts]


def score_blocks(fit: Fit) -> list[Block]:
    """How well a fit describes the records that it was fitted to, and what it leaves of each."""
    table = _with_motions(
        score_table(fit.scores, f"From {fit.settling:g} s after the motion starts, each record's own offset taken."),
        size_table(fit.residuals),
    )
    groups = group_by_input(fit.records, {name: score.l1 for name, score in fit.scores.items()})
    if len(fit.records) == 1:
        return [Text("This record was fitted: the score describes the fit and is no prediction."), table]
    return [
        Text("These records were fitted: the scores describe the fit and are not predictions."),
        FigureBlock(
            scores_by_input(groups), f"L1 ratio of each record{', by input' * (fit.residuals.unit in INPUTS)}."
        ),
        table,
    ]


def _with_motions(scores: Table, sizes: Table) -> Table:
    """The scores of the records between what each record is and what the fit leaves of it: rows of both in the same order."""
    motion = sum(name in ("input", "stroke", "freq.") for name in sizes.columns)

    def row(of_scores: Sequence[Any], of_sizes: Sequence[Any]) -> list[Any]:
        return [of_scores[0], *of_sizes[1 : motion + 1], *of_scores[1:], *of_sizes[motion + 1 :]]

    return replace(
        scores,
        columns=row(scores.columns, sizes.columns),
        rows=[row(*both) for both in zip(scores.rows, sizes.rows, strict=True)],
        units=row(scores.units, sizes.units),
        align=["left", *["right"] * (len(scores.columns) + len(sizes.columns) - 3), "left"],
        caption=f"{scores.caption} {sizes.caption}",
    )


def law_blocks(fit: Fit) -> list[Block]:
    """The laws of the parameters over the input; none where there is one input."""
    if fit.damper is None or not fit.damper.range[0] < fit.damper.range[1]:
        return []
    bars = "fitted values" if fit.clusters == "cycle" else "fitted values with 95 % intervals"
    without = " (none where an error holds within these records only)" if fit.clusters == "record and cycle" else ""
    caption = f"Parameters over the input: {bars}{without}, the laws through them, the calibrated range."
    return [FigureBlock(figure, caption) for figure in law_figures(fit, fit.damper)]


def fit_blocks(fit: Fit) -> list[Block]:
    """Parameters, their errors and laws."""
    return [*parameter_tables(fit), *law_blocks(fit)]
