"""Scores of records by the input at which they were made."""

import math
from dataclasses import replace

import pytest
from tests.show.fit_examples import records

from dampyr.identification import Score
from dampyr.identification.scoring.scoring_window import Window
from dampyr.show.identification.score_groups import scores_by_input

PERFECT = Score(0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, Window(0, 10, 0.0, 1.0))


def scored(l1: float, relevelled: float) -> Score:
    return replace(PERFECT, l1=l1, relevelled_l1=relevelled)


def test_a_row_holds_mean_and_worst_of_an_input_and_the_mean_of_those_with_a_level() -> None:
    of_records = {
        "1V-0": scored(0.10, 0.02), "1V-1": scored(0.20, math.nan), "0V-0": scored(0.05, 0.04), "0V-1": scored(0.07, 0.05),
        "2V-0": scored(0.30, math.nan),
    }  # fmt: skip
    table = scores_by_input(records(), of_records, "Scores")
    expected = [[0.0, 2, 6.0, 7.0, 4.5], [1.0, 2, 15.0, 20.0, 2.0], [2.0, 1, 30.0, 30.0, None]]
    assert len(table.rows) == 3
    for row, numbers in zip(table.rows, expected, strict=True):
        assert list(row[:4]) == pytest.approx(numbers[:4])
        assert row[4] == (None if numbers[4] is None else pytest.approx(numbers[4]))
    assert table.heads == ["input [V]", "records", "mean L1 [%]", "worst L1 [%]", "relevelled [%]"]
    assert table.caption == "Scores."


def test_without_scores_there_are_no_rows() -> None:
    assert scores_by_input(records(), {}, "Scores").rows == []
