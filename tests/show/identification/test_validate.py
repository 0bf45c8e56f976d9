"""What the validation of a card shows: scores, levels and what the card was fitted on."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.show.fit_examples import DAHL, records

from dampyr.identification import Score
from dampyr.identification.scoring.scoring_window import Window
from dampyr.identification.scoring.validate import Validated
from dampyr.show.descriptions import description_of
from dampyr.show.identification.validate import by_input, levels_and_bands, validated_scores

SCORE = Score(0.1, 0.2, 0.96, 0.1, 0.01, -0.02, 3.0, Window(100, 400, 0.5, 2.0), 1.03, 0.05)
RECORDS = tuple(records((0.0, 2.0), 2))
L1 = (0.1, 0.2, 0.3, 0.4)


@pytest.fixture
def validated() -> Validated:
    card = replace(DAHL, provenance={"records": f"{RECORDS[0].name}, {RECORDS[1].name}"})
    scores = {record.name: replace(SCORE, l1=l1) for record, l1 in zip(RECORDS, L1, strict=True)}
    forces = {record.name: np.full(record.n, 7.0) for record in RECORDS}
    return Validated("my card", card, RECORDS, scores, forces)


def test_the_text_states_mean_and_worst_and_how_many_were_seen(validated: Validated) -> None:
    rows = dict(description_of(validated).rows)
    assert rows["L1"] == f"25 % on average, 40 % in {RECORDS[3].name}"
    assert rows["records"] == "4 records, of which the damper was fitted on 2"
    assert "bands" not in rows


def test_a_row_tells_input_and_whether_it_was_fitted_on(validated: Validated) -> None:
    table = validated_scores(validated)
    assert [list(row[:3]) for row in table.rows] == [
        [record.name, u, seen]
        for record, u, seen in zip(RECORDS, (0.0, 0.0, 2.0, 2.0), ("yes", "yes", "no", "no"), strict=True)
    ]
    assert table.heads[:4] == ["record", "input [V]", "fitted on", "L1 [%]"]


def test_means_are_by_input(validated: Validated) -> None:
    rows = [list(row[:4]) for row in by_input(validated).rows]
    assert rows[0] == pytest.approx([0.0, 2, 15.0, 20.0])
    assert rows[1] == pytest.approx([2.0, 2, 35.0, 40.0])


def test_a_level_that_is_not_known_is_a_dash(validated: Validated) -> None:
    scores = dict(validated.scores) | {RECORDS[0].name: replace(SCORE, level=math.nan)}
    table = levels_and_bands(replace(validated, scores=scores, no_band="the card states no errors"))
    assert list(table.rows[0]) == [RECORDS[0].name, "0.50–2.00", None]
    assert list(table.rows[1]) == [RECORDS[1].name, "0.50–2.00", 1.03]
    assert table.notes[-1] == "The card states no errors."


def test_the_drawn_prediction_has_the_offset_of_its_record(validated: Validated) -> None:
    from matplotlib import pyplot

    top, below = validated.plot.history(RECORDS[0])
    np.testing.assert_allclose(top.lines[1].get_ydata(), 7.0 + 3.0)
    np.testing.assert_allclose(below.lines[0].get_ydata(), RECORDS[0].force - 10.0)
    pyplot.close("all")
