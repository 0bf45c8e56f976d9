"""Section of a fit's page: how well the model predicts unseen records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dampyr.identification import Fit
from dampyr.identification.fits.fit_options import SPLITS
from dampyr.identification.scoring.validation import Validation
from dampyr.input_kinds import INPUTS
from dampyr.show.figures.scores import scores
from dampyr.show.identification.fit_predictions import mean_l1
from dampyr.show.identification.score import group_by_input
from dampyr.show.pages.blocks import Block, FigureBlock, Section, Text
from dampyr.show.table import Cell, Table


def prediction_section(fit: Fit, validations: Sequence[Validation]) -> Section:
    """Predicted scores beside the fitted ones; each says what its damper was not fitted on."""
    blocks: list[Block] = [
        Text(
            "Each record is predicted by a damper that was fitted on other records with the same model: a free run, of which "
            "only the offset is taken from the record. Its parameters differ from those above. The score of the fit "
            "to all records, which includes this record, is shown for comparison."
        )
    ]
    for validation in validations:
        blocks += _split(fit, validation)
    return Section("Prediction of unseen records", blocks)


def _split(fit: Fit, validation: Validation) -> list[Block]:
    what = f"Split by {validation.split}: {SPLITS.words.get(validation.split, validation.split)}"
    record_scores = validation.scores
    if not record_scores:
        return [Text(f"{what}. No part was predicted."), _parts(validation)]
    fitted = group_by_input(fit.records, {name: fit.scores[name].l1 for name in record_scores if name in fit.scores})
    means = {name: float(np.mean(values)) for name, values in fitted.items()}
    predicted = group_by_input(fit.records, {name: score.l1 for name, score in record_scores.items()})
    references = {"mean of the fit that has seen them": means} if means else None
    return [
        FigureBlock(
            scores(predicted, references),
            f"{what}. L1 ratio of each predicted record{', by input' * (fit.residuals.unit in INPUTS)}.",
        ),
        Table(
            (
                "record",
                "part",
                "predicted L1",
                "relevelled",
                "fitted L1",
                "predicted NRMSE",
                "beyond what that damper was fitted on",
            ),
            _rows(fit, validation),
            ("", "", "%", "%", "%", "%", ""),
            caption=f"{what}; {len(record_scores)} records predicted, mean L1 {100 * mean_l1(validation):.2f} %. "
            f"With the level of each record's first cycles it is {100 * validation.relevelled:.2f} %. "
            "A record is predicted by a damper that was not fitted on any record of its part.",
            digits=3,
        ),
        _parts(validation),
        *[Text(f"{name} is not scored: {why}.") for name, why in validation.not_scored.items()],
    ]


def _rows(fit: Fit, validation: Validation) -> list[list[Cell]]:
    rows: list[list[Cell]] = []
    for number, fold in enumerate(validation.folds, 1):
        for name, score in fold.scores.items():
            fitted = fit.scores[name].l1 if name in fit.scores else float("nan")
            beyond = fold.outside.get(name, "nothing")
            rows.append(
                [name, number, 100 * score.l1, 100 * score.relevelled_l1, 100 * fitted, 100 * score.nrmse, beyond]
            )
    return rows


def _parts(validation: Validation) -> Table:
    rows: list[list[Cell]] = [
        [number, len(fold.fitted_on), ", ".join([*fold.scores, *fold.skipped]) or f"no damper: {fold.reason}"]
        for number, fold in enumerate(validation.folds, 1)
    ]
    return Table(("part", "fitted on", "not fitted on"), rows, ("", "records", ""), ("left", "right", "left"))
