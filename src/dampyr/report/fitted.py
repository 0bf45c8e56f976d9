"""What a fit found, as tables and figures that several pages share."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from dampyr.identification import Fit, Score
from dampyr.report.blocks import Block, Cell, FigureBlock, Table, Text
from dampyr.report.figures.laws import Law, parameters_against_input
from dampyr.report.style import CURRENT, VOLTAGE, Axis
from dampyr.units import for_people

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from dampyr.models import Damper


def parameter_table(fit: Fit) -> Table:
    """Every fitted number with its standard error and the naive one, in units that people read."""
    rows: list[list[Cell]] = []
    for name, value in fit.parameters.items():
        unit, factor = for_people(fit.units[name])
        rows.append(
            [
                name,
                value * factor,
                _told(fit.stderr[name], factor),
                _told(fit.naive_stderr[name], factor),
                unit,
            ]
        )
    return Table(
        columns=("parameter", "value", "standard error", "naive error", "unit"),
        rows=rows,
        caption=f"Errors allow for residuals that are correlated within each {fit.clusters}; the naive ones take every "
        "sample for independent and are shown for comparison.",
        digits=4,
    )


def _told(error: float, factor: float) -> float | str:
    if math.isnan(error):
        return "at its limit"
    return error * factor if math.isfinite(error) else "not determined"


def law_figure(fit: Fit, damper: Damper) -> Figure:
    """Each parameter over the input: the law, the fitted values with 95 % intervals, the calibrated range."""
    start, end = damper.range
    inputs = np.linspace(start, end, 200)
    intervals = fit.intervals()
    panels = []
    short = [column.name.partition(".")[2] for column in fit.problem.columns]
    for column, span in zip(fit.problem.columns, fit.problem.slices, strict=True):
        if not column.size:
            continue
        unit, factor = for_people(column.quantity.unit)
        name = column.name.partition(".")[2]
        spans = [intervals[label] for label in column.labels(damper.input)]
        errors = [0.5 * (high - low) for low, high in spans]
        points = (np.array(column.knots), fit.outcome.point.theta[span])
        if column.size == 1:
            points = (np.array([0.5 * (start + end)]), points[1])
        panels.append(
            Law(
                Axis(name if short.count(name) == 1 else column.name, unit, factor),
                curve=(inputs, damper.all_laws[column.name](inputs)),
                points=points,
                error=np.where(np.isfinite(errors), errors, 0.0),
            )
        )
    return parameters_against_input(panels, (start, end), VOLTAGE if damper.input == "V" else CURRENT)


def score_table(scores: dict[str, Score], caption: str) -> Table:
    """One row per record, ratios in percent."""
    rows: list[list[Cell]] = [
        [
            name,
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
        columns=("record", "L1", "NRMSE", "R²", "pointwise", "peak force", "energy", "offset"),
        units=("", "%", "%", "", "%", "%", "%", "N"),
        rows=rows,
        caption=caption,
        digits=3,
    )


def fit_blocks(fit: Fit) -> list[Block]:
    """Parameters, laws, and what a reader should know."""
    blocks: list[Block] = [parameter_table(fit)]
    if fit.damper is not None and fit.damper.range[0] < fit.damper.range[1]:
        blocks.append(
            FigureBlock(
                law_figure(fit, fit.damper),
                "Parameters over the input: fitted values with 95 % intervals, the laws through them, the calibrated range.",
            )
        )
    blocks.append(Text("\n\n".join(f"{sentence}." for sentence in (f"The search {fit.reason}", *fit.notes))))
    return blocks
