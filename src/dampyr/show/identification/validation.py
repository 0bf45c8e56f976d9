"""What a cross-validation shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from dampyr.identification.scoring.score import Score
from dampyr.identification.scoring.validation import Fold, Validation
from dampyr.input_kinds import ALL_RECORDS
from dampyr.phrases import counted, listing, percent
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.scores import scores
from dampyr.show.table import Table

NO_ENERGY = "Energy –: no whole cycle in the window, so it is not scored."


@describe.register
def describe_fold(fold: Fold) -> Description:
    """What was fitted and predicted, and the scores of the predicted records."""
    l1 = [score.l1 for score in fold.scores.values()]
    rows = [
        ("fitted on", counted(len(fold.fitted_on), "record")),
        ("predicted", listing(list(fold.scores), 3) if fold.scores else f"nothing: {fold.reason}"),
    ]
    if l1:
        rows.append(("L1", f"{percent(float(np.mean(l1)))} on average, {percent(max(l1))} at worst"))
    if fold.outside:
        rows.append(("outside", f"{counted(len(fold.outside), 'record')} beyond what was fitted"))
    return Description("Fold", rows, tables=[lambda: score_table(fold.scores)])


@describe.register
def describe_validation(validation: Validation) -> Description:
    """The error of all predicted records and by input, what was not scored, and the score of each record."""
    by_input = validation.by_input.items()
    rows = [
        (
            "error",
            f"{percent(validation.error)}, the mean L1 ratio of predicted records"
            + ", every input counting the same" * bool(validation.inputs),
        ),
        ("records", f"{len(validation.scores)} predicted in {counted(len(validation.folds), 'part')}"),
        ("relevelled", f"{percent(validation.relevelled)} with the level of each record's first cycles"),
    ]
    if validation.inputs:
        by_words = [f"{percent(e)} at {u:.4g} {validation.unit}".rstrip() for u, e in by_input]
        rows.append(("by input", listing(by_words)))
    if validation.not_scored:
        rows.append(("not scored", listing([f"{name}: {why}" for name, why in validation.not_scored.items()], 1)))
    if validation.failed:
        rows.append(("failed", f"{counted(len(validation.failed), 'part')}: {next(iter(validation.failed.values()))}"))
    return Description(
        f"Validation, split by {validation.split}",
        rows,
        tables=[lambda: score_table(validation.scores)],
        figure=lambda: scores(_l1_by_input(validation)) if validation.scores else None,
        data=lambda: _numbers(validation),
        frame=lambda: _columns(validation),
    )


def _l1_by_input(validation: Validation) -> dict[str, list[float]]:
    groups: dict[str, list[float]] = {}
    for u in validation.by_input:
        l1_of_input = [score.l1 for name, score in validation.scores.items() if validation.inputs.get(name, 0.0) == u]
        groups[f"{u:.4g} {validation.unit}".rstrip() if validation.inputs else ALL_RECORDS] = l1_of_input
    return groups


def _numbers(validation: Validation) -> dict[str, Any]:
    """Split, folds and inputs with their unit, for `dampyr.to_json`."""
    return {
        "split": validation.split,
        "origin": validation.origin.as_dict(),
        "error": validation.error,
        "relevelled": validation.relevelled,
        "folds": validation.folds,
        "inputs": validation.inputs,
        "unit": validation.unit,
        "not_scored": validation.not_scored,
    }


def _columns(validation: Validation) -> DataFrameColumns:
    """The score of each predicted record: ratios, the offset in N, and which part it was in."""
    part = {name: k for k, fold in enumerate(validation.folds, 1) for name in fold.scores}
    columns: dict[str, Any] = {"part": list(part.values())}
    if validation.inputs:
        columns[f"input_{validation.unit}".rstrip("_")] = [validation.inputs.get(name) for name in part]
    return DataFrameColumns(columns | score_columns(validation.scores), list(part), "record")


def score_table(scores: Mapping[str, Score], caption: str = "") -> Table:
    """One row a record, ratios in percent."""
    return Table(
        ("record", "L1", "relevelled", "NRMSE", "R²", "pointwise", "peak force", "energy", "offset"),
        [
            [
                name,
                _percent(s.l1),
                _percent(s.relevelled_l1),
                _percent(s.nrmse),
                s.r2,
                _percent(s.pointwise),
                _percent(s.peak_force),
                _percent(s.energy),
                s.offset,
            ]
            for name, s in scores.items()
        ],
        ("", "%", "%", "%", "", "%", "%", "%", "N"),
        caption=caption,
        notes=[NO_ENERGY] if any(math.isnan(s.energy) for s in scores.values()) else (),
        digits=3,
    )


def _percent(ratio: float) -> float | None:
    return None if math.isnan(ratio) else 100 * ratio


def score_columns(scores: Mapping[str, Score]) -> dict[str, list[float]]:
    """The columns of a data frame of scores: ratios, and the offset in N."""
    ratios = ("l1", "relevelled_l1", "level", "nrmse", "r2", "pointwise", "peak_force", "energy")
    names = {name: name for name in ratios} | {"offset": "offset_N"}
    return {head: [getattr(score, name) for score in scores.values()] for name, head in names.items()}
