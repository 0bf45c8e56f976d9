"""The section on how well a model predicts unseen records."""

from dataclasses import replace
from pathlib import Path

import pytest
from tests.show.pages.test_html_page import Reader

from dampyr.identification import Fit, Score
from dampyr.identification.scoring.validation import Fold, Validation
from dampyr.show.pages.blocks import Section, Text
from dampyr.show.pages.prediction_section import prediction_section
from dampyr.show.pages.result_page import write_page


def some_score(template: Score, l1: float) -> Score:
    return replace(template, l1=l1)


@pytest.mark.usefixtures("figures_not_rendered")
def test_predictions_say_what_they_were_not_fitted_on_and_sections_come_first(joint: Fit, tmp_path: Path) -> None:
    names = [r.name for r in joint.records]
    one = joint.scores[names[0]]
    folds = (
        Fold(
            tuple(names[2:]),
            {names[0]: some_score(one, 0.25), names[1]: some_score(one, 0.35)},
            True,
            "",
            {names[1]: "too fast"},
        ),
        Fold(tuple(names[:2]), {}, False, "a law fell below 0", {}),
    )
    section = prediction_section(joint, [Validation("record", folds)])
    table, parts = section.blocks[-2:]
    assert [list(row) for row in table.rows] == [
        [names[0], 1, 25.0, 100 * one.relevelled_l1, 100 * one.l1, 100 * one.nrmse, "nothing"],
        [names[1], 1, 35.0, 100 * one.relevelled_l1, 100 * joint.scores[names[1]].l1, 100 * one.nrmse, "too fast"],
    ]
    assert [list(row) for row in parts.rows] == [
        [1, len(names) - 2, f"{names[0]}, {names[1]}"],
        [2, 2, "no damper: a law fell below 0"],
    ]
    extra = [Section("Which model", [Text("The leader.")]), Section("Another", [Text("More.")])]
    predicted = replace(joint, validations=(Validation("record", folds),))
    path = write_page(predicted, tmp_path / "page.html", sections=extra)
    html = path.read_text("utf-8")
    titles = Reader(html).inside("h2")
    assert titles[:4] == ["In short", "Which model", "Another", "Findings"]
    first = titles.index("Goodness of fit")
    assert titles[first + 1] == "Prediction of unseen records"
    assert "L1 30 % on average, 2 records, split by record" in html


def test_a_validation_that_predicted_nothing_is_shown(joint: Fit) -> None:
    empty = Validation("input", (Fold(("a",), {}, False, "no damper came of it", {}),))
    text, parts = prediction_section(joint, [empty]).blocks[1:]
    assert "No part was predicted" in text.text
    assert list(parts.rows[0]) == [1, 1, "no damper: no damper came of it"]
