"""Cross-validation: nothing is predicted by what it was fitted on."""

import pytest
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import cross_validate
from dampyr.models import Damper, Interpolation
from dampyr.records import Record

VOLTS = (0.0, 1.0, 2.0, 3.0)


@pytest.fixture(scope="module")
def records() -> list[Record]:
    damper = Damper(
        "dahl",
        {
            "dahl.kx": Interpolation(VOLTS, (800.0, 1300.0, 1800.0, 2300.0)),
            "dahl.kw": Interpolation(VOLTS, (50.0, 200.0, 350.0, 500.0)),
            "dahl.rho": 3000.0,
        },
    )
    return [
        sine(damper, u, f"{u:g}V-{k}", 0.004 + 0.002 * k, 1.3 - 0.2 * k, noise=1.0, seed=k)
        for u in VOLTS
        for k in range(3)
    ]


@pytest.mark.parametrize("split", ["record", "frequency", "amplitude"])
def test_every_record_is_predicted_once_by_a_fit_that_never_saw_it(records: list[Record], split: str) -> None:
    done = cross_validate("dahl", records, split=split, folds=4)
    assert sorted(done.scores) == sorted(r.name for r in records)
    for fold in done.folds:
        assert not set(fold.fitted_on) & set(fold.scores)
        assert len(fold.fitted_on) + len(fold.scores) == len(records)
    assert max(s.l1 for s in done.scores.values()) < 0.05
    assert done.failed == {}


def test_leaving_an_input_out_predicts_only_between_others(records: list[Record]) -> None:
    done = cross_validate("dahl", records, split="input")
    assert sorted(done.scores) == sorted(r.name for r in records if r.voltage in (1.0, 2.0))
    assert len(done.folds) == 2
    assert max(s.l1 for s in done.scores.values()) < 0.05


def test_what_lies_beyond_the_fitted_records_is_told(records: list[Record]) -> None:
    done = cross_validate("dahl", records, split="amplitude", folds=3)
    told = {name: text for fold in done.folds for name, text in fold.outside.items()}
    assert {name.partition("-")[2] for name in told} == {"2"}
    assert all("displacement reaches 0.008 m" in text for text in told.values())


def test_folds_repeat_by_seed(records: list[Record]) -> None:
    one, same, other = (cross_validate("dahl", records, folds=3, seed=s) for s in (1, 1, 2))
    assert [f.fitted_on for f in one.folds] == [f.fitted_on for f in same.folds]
    assert [f.fitted_on for f in one.folds] != [f.fitted_on for f in other.folds]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"split": "weather"}, "'weather' is no split"),
        ({"folds": 1}, "at least 2 folds"),
        ({"folds": 99}, "99 folds of 12 records"),
    ],
)
def test_wrong_splits_are_refused(records: list[Record], options: dict, words: str) -> None:  # type: ignore[type-arg]
    with pytest.raises(InputError, match=words):
        cross_validate("dahl", records, **options)


def test_two_inputs_cannot_be_left_out(records: list[Record]) -> None:
    with pytest.raises(InputError, match="three or more; the records have 2"):
        cross_validate("dahl", [r for r in records if r.voltage in (0.0, 1.0)], split="input")
