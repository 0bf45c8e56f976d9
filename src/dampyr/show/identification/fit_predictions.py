"""What a fit shows of predictions, of the choice of its model, and of what its records do not separate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from dampyr.identification.fits.fit_options import SPLITS
from dampyr.identification.fits.result import Fit
from dampyr.identification.parameter_uncertainty.identifiability import SESSION_FINDING, identifiability
from dampyr.identification.scoring.validation import Validation
from dampyr.phrases import counted, percent
from dampyr.show.identification.score_groups import scores_by_input
from dampyr.show.table import Cell, Table


def choice_row(fit: Fit) -> list[tuple[str, str]]:
    """Of how many models it is, and by what error; nothing where the model was named."""
    board = fit.leaderboard
    if board is None:
        return []
    return [("chosen", f"of {counted(len(board.screened), 'model')} by {percent(board.winner.error)}")]


def prediction_rows(fit: Fit) -> list[tuple[str, str]]:
    """What it predicts of records that it was not fitted on, a line for each way of choosing them."""
    rows = [("predicts", f"{percent(v.error)} L1, split by {v.split}") for v in fit.validations]
    if fit.predicted:
        rows.append(("validation", f"{counted(len(fit.predicted), 'record')}, L1 {_mean_of_validation(fit)}"))
    return rows


def prediction_tables(fit: Fit) -> list[Callable[[], Table]]:
    """What the records do not separate, and the scores of records that were predicted."""
    return [
        lambda: _inseparable(fit),
        *(partial(_prediction, fit, validation) for validation in fit.validations),
        *([lambda: _validation_records(fit)] if fit.predicted else []),
    ]


def _mean_of_validation(fit: Fit) -> str:
    l1 = [score.l1 for score in fit.predicted.values() if not isinstance(score, str)]
    return percent(sum(l1) / len(l1)) if l1 else "none could be predicted"


def predictions_in_words(fit: Fit) -> list[str]:
    """How well records are predicted that the model was not fitted on, a sentence for each way of choosing them."""
    sentences = [prediction_in_words(validation) for validation in fit.validations]
    if fit.predicted:
        records = counted(len(fit.predicted), "validation record")
        sentences.append(f"Predicts {records} with L1 {_mean_of_validation(fit)}.")
    return sentences


def prediction_in_words(validation: Validation) -> str:
    """How well the records of a validation are predicted, by fits without them, in a sentence."""
    parts = SPLITS.words.get(validation.split, validation.split)
    if not validation.scores:
        return f"No record was predicted by {parts}."
    records = counted(len(validation.scores), "record")
    l1 = percent(mean_l1(validation))
    return f"Predicts records that it was not fitted on with L1 {l1} on average ({records}; {parts})."


def mean_l1(validation: Validation) -> float:
    """The mean L1 of the predicted records, NaN without any."""
    values = [score.l1 for score in validation.scores.values()]
    return float(np.mean(values)) if values else float("nan")


def _inseparable(fit: Fit) -> Table:
    """What the fitted records do not separate, a line each; none where they separate all."""
    # what the levels of the fit say of sessions, and how to settle it, is among its findings
    of_sessions = fit.levels is not None and bool(fit.levels.settles)
    rows = [
        [inseparable.brief]
        for inseparable in identifiability(fit).inseparable
        if not (of_sessions and inseparable.kind == SESSION_FINDING)
    ]
    return Table(("not separated",), rows, caption="What these records do not separate, and the test that would.")


def _prediction(fit: Fit, validation: Validation) -> Table:
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
    table = scores_by_input(fit.records, validation.scores, caption)
    return replace(table, notes=[*(f"{trouble}." for trouble in troubles), *table.notes])


def _validation_records(fit: Fit) -> Table:
    rows: list[list[Cell]] = [
        [name, None, None, score] if isinstance(score, str) else [name, 100 * score.l1, 100 * score.relevelled_l1, ""]
        for name, score in fit.predicted.items()
    ]
    return Table(
        ("record", "L1", "relevelled", ""),
        rows,
        ("", "%", "%", ""),
        caption="Prediction of the validation records.",
        digits=3,
    )


def prediction_numbers(fit: Fit) -> dict[str, Any]:
    """What the records do not separate, the predictions and the choice of the model, SI units."""
    data: dict[str, Any] = {"identifiability": identifiability(fit).as_dict()["inseparable"]}
    if fit.validations:
        data["predictions"] = list(fit.validations)
    if fit.leaderboard is not None:
        data["leaderboard"] = fit.leaderboard.as_dict()
    if fit.predicted:
        data["validation"] = {
            name: {"problem": score} if isinstance(score, str) else score.as_dict()
            for name, score in fit.predicted.items()
        }
    return data
