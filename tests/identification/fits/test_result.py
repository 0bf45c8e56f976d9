"""A fit as a result: intervals, ranges, scores and its dictionary."""

import json

import pytest
from tests.identification.campaign_of_dahl import TRUTH, campaign
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import fit, score
from dampyr.models import Damper
from dampyr.to_json import plain


def test_a_record_that_settling_takes_most_of_is_scored_from_its_start_and_the_note_says_so() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    short = sine(truth, 0.0, "short", seconds=2.7)
    fit_result = fit(short, "dahl")
    assert fit_result.scores["short"].window.start == pytest.approx(0.5, abs=0.02)
    assert any("short: too short for a settling of 2 s" in note for note in map(str, fit_result.findings))
    assert fit(short, "dahl", settling=0.5).scores["short"].window.start == pytest.approx(1.0, abs=0.02)
    with pytest.raises(
        InputError, match=r"its motion lasts 2.19 s and settling takes the first 2 s of it, so 0.19 s \(3\d"
    ):
        score(truth, short)


def test_the_calibrated_ranges_are_those_of_the_records() -> None:
    fit_result = fit(campaign(Damper("dahl", TRUTH)), "dahl")
    assert fit_result.damper is not None
    assert fit_result.damper.range == (0.0, 3.0)
    assert fit_result.damper.ranges["displacement"][1] == pytest.approx(0.007, rel=0.05)
    assert fit_result.damper.ranges["frequency"] == pytest.approx((1.0, 1.2), rel=0.02)


def test_a_free_run_of_the_fit_scores_like_the_fit() -> None:
    records = campaign(Damper("dahl", TRUTH), noise=2.0)
    fit_result = fit(records, "dahl")
    assert fit_result.damper is not None
    for record in records:
        assert score(fit_result.damper, record).l1 == pytest.approx(fit_result.scores[record.name].l1, rel=0.02)


def test_intervals_are_students() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fit_result = fit([sine(truth, 0.0, f"r{k}", noise=3.0, seed=k) for k in range(6)], "dahl")
    assert fit_result.freedom["dahl.kw"] == pytest.approx(5.0, abs=0.1)
    low, high = fit_result.intervals(0.95)["dahl.kw"]
    assert (high - low) / 2 == pytest.approx(2.5706 * fit_result.stderr["dahl.kw"], rel=0.02)
    with pytest.raises(InputError, match="between 0 and 1"):
        fit_result.intervals(95)


def test_a_fit_as_a_dict_has_every_number_by_its_label() -> None:
    fit_result = fit(
        sine(Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 55.0, "dahl.rho": 2500.0}), 0.0, noise=1.0), "dahl"
    )
    data = plain(fit_result.as_dict())
    assert json.loads(json.dumps(data)) == data
    assert list(data["parameters"]) == list(data["stderr"]) == list(data["intervals_95"]) == list(fit_result.parameters)
    assert data["intervals_95"] == dict.fromkeys(fit_result.within_records)
    assert data["scores"] == {name: plain(score) for name, score in fit_result.scores.items()}
