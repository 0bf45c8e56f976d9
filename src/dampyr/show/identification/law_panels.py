"""Panels of fitted laws: each parameter over the input, the fitted values with their intervals, and the law through them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dampyr.identification.search.optimum import Optimum
from dampyr.models import Damper
from dampyr.show.figures.laws import LawPanel
from dampyr.show.figures.style import Axis
from dampyr.units import for_people

CURVE = 200  # inputs of a law's curve


def law_panels(optimum: Optimum, intervals: Mapping[str, tuple[float, float]], damper: Damper) -> list[LawPanel]:
    """One panel for each parameter that was fitted, for `dampyr.show.figures.laws.parameters_against_input`."""
    start, end = damper.range
    usual = damper.at_mean_temperature
    inputs = np.linspace(start, end, CURVE)
    panels, problem = [], optimum.problem
    short = [column.name.partition(".")[2] for column in problem.columns]
    for column, span in zip(problem.columns, problem.slices, strict=True):
        if not column.size:
            continue
        unit, factor = for_people(column.quantity.unit)
        name = column.name.partition(".")[2]
        spans = [intervals[label] for label in column.labels(damper.input)]
        errors = [0.5 * (high - low) for low, high in spans]
        points = (np.tile(column.knots, column.size // len(column.knots)), optimum.point.theta[span])
        if column.size == 1:
            points = (np.array([0.5 * (start + end)]), points[1])
        panels.append(
            LawPanel(
                Axis(name if short.count(name) == 1 else column.name, unit, factor),
                curve=(inputs, usual.all_laws[column.name](inputs)),
                points=points,
                error=np.where(np.isfinite(errors), errors, 0.0),
            )
        )
    return panels
