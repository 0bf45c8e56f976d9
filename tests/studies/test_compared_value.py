"""A verdict follows from two numbers and a stated tolerance."""

import math

import pytest

from dampyr.studies._compared_value import (
    AlternativeValue,
    ComparisonTolerance,
    PrintedNumber,
    judge,
    overall,
    unchecked,
)


@pytest.mark.parametrize(
    ("text", "ours", "verdict"),
    [
        ("6.7375", 6.7375862, "agrees"),  # cut
        ("6.7375", 6.7374501, "agrees"),  # rounded
        ("6.7375", 6.73744, "differs"),
        ("6.7375", 6.7376001, "differs"),
        ("-6.3199", -6.3199964, "agrees"),  # cut towards zero
        ("-6.3199", -6.31984, "differs"),
        ("0.8020", 0.80204, "agrees"),
        ("7.8957e-5", 7.89568e-5, "agrees"),
        ("7.8957e-5", 7.8959e-5, "differs"),
    ],
)
def test_printed_digits_may_be_rounded_or_cut(text: str, ours: float, verdict: str) -> None:
    assert judge("a", "q", PrintedNumber(text), ours).verdict == verdict


def test_a_tolerance_is_stated_and_kept() -> None:
    inside = judge("a", "q", 100.0, 104.9, "mm", ComparisonTolerance(relative=0.05))
    outside = judge("a", "q", 100.0, 105.1, "mm", ComparisonTolerance(relative=0.05))
    assert (inside.verdict, outside.verdict) == ("agrees", "differs")
    assert "5 %" in inside.reason
    assert "5 %" in outside.reason


def test_the_reason_is_the_candidate_that_meets_the_printed_value() -> None:
    candidates = [AlternativeValue(3.0, "the first"), AlternativeValue(7.0, "the second")]
    assert "the second (7)" in judge("a", "q", PrintedNumber("7"), 5.0, candidates=candidates, otherwise="none").reason
    assert judge("a", "q", PrintedNumber("8"), 5.0, candidates=candidates, otherwise="none").reason.endswith(
        "Because: none"
    )


def test_nothing_finite_cannot_be_checked() -> None:
    value = judge("a", "q", 1.0, math.nan)
    assert (value.verdict, value.ours) == ("cannot be checked", None)


def test_an_artefact_differs_where_one_number_does() -> None:
    same, other, lost = judge("a", "q", 1.0, 1.0), judge("a", "q", 1.0, 2.0), unchecked("a", "q", 1.0, "", "no file")
    assert overall([same, lost]) == "agrees"
    assert overall([same, other, lost]) == "differs"
    assert overall([lost]) == "cannot be checked"
