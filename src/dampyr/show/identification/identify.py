"""What the result of `dampyr.identification.identify` shows."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from dampyr.findings import as_dicts
from dampyr.identification.fits.identify import SPLIT_WORDS, Identified
from dampyr.identification.parameter_uncertainty.identifiability import SESSION_FINDING
from dampyr.identification.scoring.validation import Validation
from dampyr.phrases import counted, percent
from dampyr.show.descriptions import Description, describe
from dampyr.show.identification.result import describe_fit
from dampyr.show.identification.score_groups import scores_by_input
from dampyr.show.table import Cell, Table
from dampyr.to_json import plain


@describe.register
def describe_identified(result: Identified) -> Description:
    """What its fit shows, the choice of the model, the predictions, and what the records do not separate."""
    fit = describe_fit(result.fit)
    rows = [*fit.rows, *(("predicts", f"{percent(v.error)} L1, split by {v.split}") for v in result.validations)]
    if result.board is not None:
        words = f"of {counted(len(result.board.screened), 'model')} by {percent(result.board.winner.error)}"
        rows.insert(0, ("chosen", words))
    if result.predicted:
        rows.append(("validation", f"{counted(len(result.predicted), 'record')}, L1 {_mean_of_validation(result)}"))
    return replace(
        fit,
        title=fit.title.replace("Fit", "Identified", 1),
        rows=rows,
        verdict=[*fit.verdict, *_predictions(result)],
        tables=[
            *fit.tables,
            lambda: _inseparable(result),
            *(partial(_prediction, result, validation) for validation in result.validations),
            *([lambda: _validation_records(result)] if result.predicted else []),
        ],
        data=lambda: _numbers(result),
    )


def _mean_of_validation(result: Identified) -> str:
    l1 = [score.l1 for score in result.predicted.values() if not isinstance(score, str)]
    return percent(sum(l1) / len(l1)) if l1 else "none could be predicted"


def _predictions(result: Identified) -> list[str]:
    """How well records are predicted that the model was not fitted on, a sentence for each way of choosing them."""
    sentences = [prediction_in_words(validation) for validation in result.validations]
    if result.predicted:
        records = counted(len(result.predicted), "validation record")
        sentences.append(f"Predicts {records} with L1 {_mean_of_validation(result)}.")
    return sentences


def prediction_in_words(validation: Validation) -> str:
    """How well the records of a validation are predicted, by fits without them, in a sentence."""
    parts = SPLIT_WORDS.get(validation.split, validation.split)
    if not validation.scores:
        return f"No record was predicted by {parts}."
    records = counted(len(validation.scores), "record")
    l1 = percent(mean_l1(validation))
    return f"Predicts records that it was not fitted on with L1 {l1} on average ({records}; {parts})."


def mean_l1(validation: Validation) -> float:
    """The mean L1 of the predicted records, NaN without any."""
    values = [score.l1 for score in validation.scores.values()]
    return float(np.mean(values)) if values else float("nan")


def _inseparable(result: Identified) -> Table:
    """What the fitted records do not separate, a line each; none where they separate all."""
    # what the levels of the fit say of sessions, and how to settle it, is among its findings
    of_sessions = result.fit.levels is not None and bool(result.fit.levels.settles)
    rows = [
        [inseparable.brief]
        for inseparable in result.identifiability.inseparable
        if not (of_sessions and inseparable.kind == SESSION_FINDING)
    ]
    return Table(("not separated",), rows, caption="What these records do not separate, and the test that would.")


def _prediction(result: Identified, validation: Validation) -> Table:
    """The scores of records that the model was not fitted on, by input, and the parts that gave none."""
    parts = f"{counted(len(validation.folds), 'part')} by {validation.split}"
    troubles = [
        f"a part of {len(fold.fitted_on)} records gave no damper: {fold.reason}"
        for fold in validation.folds
        if not (fold.scores or fold.skipped)
    ]
    troubles += [
        f"a fit on {len(fold.fitted_on)} records {fold.reason}"
        for fold in validation.folds
        if fold.scores and not fold.converged
    ]
    troubles += [f"{name} is not scored: {why}" for name, why in validation.not_scored.items()]
    caption = f"Prediction of records that it was not fitted on, {parts}"
    table = scores_by_input(result.fit.records, validation.scores, caption)
    return replace(table, notes=[*(f"{trouble}." for trouble in troubles), *table.notes])


def _validation_records(result: Identified) -> Table:
    rows: list[list[Cell]] = [
        [name, None, None, score] if isinstance(score, str) else [name, 100 * score.l1, 100 * score.relevelled_l1, ""]
        for name, score in result.predicted.items()
    ]
    return Table(
        ("record", "L1", "relevelled", ""),
        rows,
        ("", "%", "%", ""),
        caption="Prediction of the validation records.",
        digits=3,
    )


def _numbers(result: Identified) -> dict[str, Any]:
    """All results, SI units."""
    data = result.fit.as_dict() | {"findings": as_dicts(result.findings)}
    data["identifiability"] = result.identifiability.as_dict()["inseparable"]
    if result.validations:
        data["predictions"] = list(result.validations)
    if result.board is not None:
        data["leaderboard"] = result.board.as_dict()
    if result.predicted:
        data["validation"] = {
            name: {"problem": score} if isinstance(score, str) else score.as_dict()
            for name, score in result.predicted.items()
        }
    return dict(plain(data))
