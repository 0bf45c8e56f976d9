"""What a fit shows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import as_dicts
from dampyr.identification.fits.result import Fit
from dampyr.input_kinds import INPUTS, NO_INPUT, unit_of
from dampyr.phrases import counted, extent, listing, percent, rounded, with_reach
from dampyr.records import Record
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.history import history
from dampyr.show.figures.laws import parameters_against_input
from dampyr.show.figures.loops import loops
from dampyr.show.identification.fit_predictions import (
    choice_row,
    prediction_numbers,
    prediction_rows,
    prediction_tables,
    predictions_in_words,
)
from dampyr.show.identification.law_panels import law_panels
from dampyr.show.identification.score_groups import scores_by_input
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Cell, Table
from dampyr.units import for_people

Array = NDArray[np.float64]
SHOWN = 6  # parameters that a short text lists one by one
INTERVAL = "value ± half of the 95 % interval"


@describe.register
def describe_fit(fit: Fit) -> Description:
    """Records, search, misfit and parameters; tables of values, errors and goodness of fit; the loops of the median record."""
    return Description(
        f"Fit {str(fit.problem.composition)!r}",
        [*choice_row(fit), *_rows(fit), *prediction_rows(fit)],
        verdict=[fit.verdict.words, *predictions_in_words(fit)],
        tables=[
            lambda: parameter_table(fit),
            *([lambda: session_table(fit)] if fit.levels is not None else []),
            lambda: error_table(fit),
            lambda: scores_by_input(fit.records, fit.scores, "Goodness of fit (not a prediction)"),
            *prediction_tables(fit),
        ],
        figure=lambda: loops(*measured_and_fitted(fit), record_origin=fit.origin),
        data=lambda: _numbers(fit),
        frame=lambda: _parameters(fit),
    )


def _rows(fit: Fit) -> list[tuple[str, str]]:
    scores = [score.l1 for score in fit.scores.values()]
    samples = sum(piece.t.size for piece in fit.problem.pieces)
    unit = fit.residuals.unit
    inputs = f", at {listing([f'{u:.4g}' for u in fit.residuals.inputs])} {unit}" if unit in INPUTS else ""
    rows = [
        ("records", f"{len(fit.records)}, {samples} samples{inputs}"),
        ("search", ("" if fit.converged else "did not converge: ") + fit.reason),
        ("L1", f"{percent(float(np.mean(scores)))} on average, {percent(max(scores))} at worst, of the fitted records"),
    ]
    by_name: dict[str, list[str]] = {}
    for label in fit.parameters:
        by_name.setdefault(label.partition(" @ ")[0], []).append(label)
    for name, labels in list(by_name.items())[:SHOWN]:
        unit, factor = for_people(fit.units[labels[0]])
        rows.append((name, extent([fit.parameters[label] for label in labels], unit, factor)))
    if len(by_name) > SHOWN:
        rows.append(("", f"and {len(by_name) - SHOWN} more parameters"))
    return [*rows, ("errors", f"clustered by {fit.clusters}")]


def parameter_table(fit: Fit) -> Table:
    """Each fitted number and half of its 95 % interval, or why it has none: a row a parameter, a column an input."""
    spans = fit.intervals()
    cells = {label: _value(fit, label, spans) for label in fit.parameters}
    return _by_input(fit, cells, f"{fit.problem.composition}, {counted(len(fit.records), 'record')}: {INTERVAL}.")


def session_table(fit: Fit) -> Table:
    """The same with what the levels of the measurement sessions may have moved; only for a fit that has levels."""
    assert fit.levels is not None
    spans = fit.intervals(between="sessions")
    cells = {label: _value(fit, label, spans) for label in fit.parameters}
    caption = f"The same between measurement sessions, whose level differs by {fit.levels.spread_words}: {INTERVAL}."
    return _by_input(fit, cells, caption)


def error_table(fit: Fit) -> Table:
    """The standard error of each fitted number, and in parentheses the naive one, which takes the samples for independent."""
    cells = {label: _error(fit, label) for label in fit.parameters}
    return _by_input(fit, cells, "Standard errors (naive ones in parentheses, as if samples were independent).")


def fits_by_record(fits: Sequence[Fit]) -> Table:
    """One row a fit, each of one record by itself: its numbers, the misfit, and whether the search converged."""
    names = list(fits[0].parameters)
    shown = [for_people(fits[0].units[name]) for name in names]
    rows: list[list[Cell]] = []
    for fit in fits:
        [record] = fit.records
        values = [value * factor for value, (_, factor) in zip(fit.parameters.values(), shown, strict=True)]
        state = "yes" if fit.converged else fit.reason
        rows.append([record.name, record.input_value, *values, 100 * fit.scores[record.name].l1, state])
    kind = fits[0].records[0].input
    table = Table(
        ("record", "input", *names, "L1", "converged"),
        rows,
        ("", unit_of(kind), *(unit for unit, _ in shown), "%", ""),
        caption=f"{fits[0].problem.composition}, each of {counted(len(fits), 'record')} by itself.",
        digits=4,
    )
    return table.without("input") if kind == NO_INPUT else table


def _by_input(fit: Fit, cells: Mapping[str, str], caption: str) -> Table:
    """One row a parameter, one column an input, in units that people read."""
    unit = fit.problem.pieces[0].unit
    free = [column for column in fit.problem.columns if column.size]
    knots = sorted({u for column in free if len(column.knots) > 1 for u in column.knots})
    everywhere = not knots or any(len(column.knots) == 1 for column in free)
    at_all_inputs = ["all inputs" if unit in INPUTS else "value"] * everywhere
    heads = ["parameter", "unit", *at_all_inputs, *(f"{u:g} {unit}" for u in knots)]
    rows: list[list[Any]] = []
    for column in free:
        shown, _ = for_people(column.quantity.unit)
        texts = [cells[label] for label in column.labels(unit)]
        for k, temperature in enumerate(column.temperatures or (None,)):
            name = column.name if temperature is None else f"{column.name}, {temperature:.4g} °C"
            at_knots = texts[k * len(column.knots) : (k + 1) * len(column.knots)]
            by_knot = dict(zip(column.knots, at_knots, strict=True)) if len(at_knots) > 1 else {}
            at_all = ["" if by_knot else at_knots[0]] * everywhere
            rows.append([name, shown or "1", *at_all, *(by_knot.get(u, "") for u in knots)])
    align = ("left", "left", *("right",) * (len(heads) - 2))
    return Table(tuple(heads), rows, align=align, caption=caption)


def _value(fit: Fit, label: str, spans: Mapping[str, tuple[float, float]]) -> str:
    _, factor = for_people(fit.units[label])
    value, reach = factor * fit.parameters[label], factor * (spans[label][1] - fit.parameters[label])
    if label in fit.within_records:
        return f"{rounded(value, 4)} (no interval)"
    if math.isnan(reach):
        return f"{rounded(value, 4)} (at its limit)"
    if not math.isfinite(reach):
        return f"{rounded(value, 4)} (not determined)"
    return with_reach(value, reach)


def _error(fit: Fit, label: str) -> str:
    _, factor = for_people(fit.units[label])
    error, naive = fit.stderr[label], fit.naive_stderr[label]
    if math.isnan(error):
        return "at its limit"
    if not math.isfinite(error):
        return "not determined"
    where = ", within these records only" if label in fit.within_records else ""
    return f"{rounded(factor * error, 2)} ({rounded(factor * naive, 2)}){where}"


def _parameters(fit: Fit) -> DataFrameColumns:
    """The fitted numbers in SI units: value, errors, 95 % interval, unit; a row a parameter."""
    spans = fit.intervals()
    columns = {
        "value": list(fit.parameters.values()),
        "standard_error": [fit.stderr[label] for label in fit.parameters],
        "naive_error": [fit.naive_stderr[label] for label in fit.parameters],
        "low_95": [spans[label][0] for label in fit.parameters],
        "high_95": [spans[label][1] for label in fit.parameters],
        "unit": [fit.units[label] for label in fit.parameters],
    }
    return DataFrameColumns(columns, list(fit.parameters), "parameter")


def _numbers(fit: Fit) -> dict[str, Any]:
    """Parameters, errors, findings and scores by name; 95 % intervals, None where there is none."""
    spans = {between: fit.intervals(between=between) for between in ("records", "sessions")}
    intervals = {
        between: {name: None if name in fit.within_records else span for name, span in by_name.items()}
        for between, by_name in spans.items()
    }
    return {
        "model": str(fit.problem.composition),
        "origin": fit.origin.as_dict(),
        "records": [record.name for record in fit.records],
        "converged": fit.converged,
        "reason": fit.reason,
        "verdict": {"kind": fit.verdict.kind, "words": fit.verdict.words},
        "findings": as_dicts(fit.findings),
        "clusters": fit.clusters,
        "parameters": fit.parameters,
        "stderr": fit.stderr,
        "naive_stderr": fit.naive_stderr,
        "intervals_95": intervals["records"],
        "intervals_95_between_sessions": intervals["sessions"],
        "within_records_only": {name: fit.why_no_interval(name) for name in fit.within_records},
        "units": fit.units,
        "correlation": fit.correlation,
        "nuisances": fit.nuisances,
        "levels": None if fit.levels is None else fit.levels.as_dict(),
        "scores": fit.scores,
        **prediction_numbers(fit),
    }


def measured_and_fitted(
    fit: Fit, record: str | Record | None = None
) -> tuple[Array, Array, Array, dict[str, Array], str]:
    """Displacement m, velocity m/s, measured force N, that of the fit by its name, and the record: what `loops` draws.

    ``record`` is the name of one of the fitted records; without it that with the median L1 ratio.
    """
    k = number_of(fit, record)
    piece = fit.problem.pieces[k]
    return piece.x, piece.v, piece.force, {"fit": fit.forces[k]}, piece.name


def number_of(fit: Fit, record: str | Record | None) -> int:
    """The place of a record, or of that name, among the fitted ones; without it that of the median L1 ratio."""
    names = [piece.name for piece in fit.problem.pieces]
    if record is None:
        errors = [score.l1 for score in fit.scores.values()]
        return int(np.argsort(errors)[len(errors) // 2])
    name = record if isinstance(record, str) else record.name
    if name not in names:
        raise InputError(f"{name!r} is not among the fitted records; choose from {listing(names, 8)}")
    return names.index(name)


@dataclass(frozen=True)
class FitPlots(Plots):
    """``fit.plot.loops()``, which is what ``fit.plot()`` draws, ``.history()``, ``.residual()`` and ``.laws()``.

    ``record`` is one of the fitted records, or its name; without it that with the median L1 ratio is drawn.
    """

    result: Fit

    def loops(self, record: str | Record | None = None) -> Any:
        """Measured and fitted force over displacement and over velocity."""
        fit = self.result
        record_origin = fit.records[number_of(fit, record)].origin
        return style.in_pyplot(loops, *measured_and_fitted(fit, record), record_origin=record_origin, origin=fit.origin)

    def history(self, record: str | Record | None = None) -> Any:
        """Measured and fitted force over time, and the residual below."""
        fit = self.result
        k = number_of(fit, record)
        piece = fit.problem.pieces[k]
        drawn, measured = (piece.t, piece.force, fit.forces[k]), fit.records[k].origin
        return style.in_pyplot(history, *drawn, name="fit", title=piece.name, record_origin=measured, origin=fit.origin)

    def residual(self) -> Any:
        """The residual over the velocity, a panel an input: median and quartiles, before and beyond the stroke's middle."""
        return self.result.residuals.plot.velocity()

    def laws(self) -> Any:
        """Each parameter over the input: the law, the fitted values with 95 % intervals, the calibrated range."""
        fit, damper = self.result, self.result.damper
        if damper is None:
            raise InputError(f"this fit made no damper, so there are no laws to draw: {fit.reason}")
        axis = style.input_axis(damper.input)
        panels = law_panels(fit.optimum, fit.intervals(), damper)
        return style.in_pyplot(parameters_against_input, panels, damper.range, axis, origin=fit.origin)


plots.register(Fit, FitPlots)
