"""What a fit shows of predictions of records that it was not fitted on."""

import math
from dataclasses import replace

import pytest

from dampyr.identification import Fit
from dampyr.identification.scoring.validation import Fold, Validation
from dampyr.show.identification.fit_predictions import (
    choice_row,
    mean_l1,
    prediction_in_words,
    prediction_rows,
    prediction_tables,
    predictions_in_words,
)


@pytest.fixture
def validation(joint: Fit) -> Validation:
    names = [record.name for record in joint.records]
    template = joint.scores[names[0]]
    predicted = {name: replace(template, l1=l1) for name, l1 in zip(names[:3], (0.1, 0.2, 0.6), strict=True)}
    return Validation(
        "record", (Fold(tuple(names[3:]), predicted, True, "", {}), Fold(("a", "b"), {}, False, "it fell", {}))
    )


def test_the_mean_is_over_the_predicted_records(validation: Validation) -> None:
    assert mean_l1(validation) == pytest.approx(0.3)
    assert "with L1 30 % on average (3 records; " in prediction_in_words(validation)
    assert math.isnan(mean_l1(Validation("record", ())))
    assert prediction_in_words(Validation("record", ())).startswith("No record was predicted by ")


def test_a_part_without_a_damper_is_told_below_the_table(joint: Fit, validation: Validation) -> None:
    table = prediction_tables(replace(joint, validations=(validation,)))[1]()
    assert table.notes[0] == "a part of 2 records gave no damper: it fell."
    assert sum(int(row[1]) for row in table.rows) == 3  # type: ignore[arg-type]


def test_validation_records_that_could_not_be_predicted_do_not_count(joint: Fit) -> None:
    score = replace(next(iter(joint.scores.values())), l1=0.25)
    fit = replace(joint, predicted={"v": score, "w": "its voltage is too high"})
    assert prediction_rows(fit) == [("validation", "2 records, L1 25 %")]
    assert predictions_in_words(fit) == ["Predicts 2 validation records with L1 25 %."]
    rows = [list(row) for row in prediction_tables(fit)[-1]().rows]
    assert rows[0][:2] == ["v", 25.0]
    assert rows[1] == ["w", None, None, "its voltage is too high"]


def test_a_named_model_was_not_chosen(joint: Fit) -> None:
    assert choice_row(joint) == []
