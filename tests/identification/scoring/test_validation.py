"""Cross-validation: nothing is predicted by what it was fitted on."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import FitOptions
from dampyr.identification.scoring.validation import cross_validate
from dampyr.models import Damper, Interpolation
from dampyr.records import Record
from dampyr.to_json import plain

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


@pytest.mark.parametrize(
    "split", ["record", *(pytest.param(split, marks=pytest.mark.prove) for split in ("frequency", "amplitude"))]
)
def test_every_record_is_predicted_once_by_a_fit_that_never_saw_it(records: list[Record], split: str) -> None:
    done = cross_validate(records, "dahl", split, FitOptions(folds=4))
    assert sorted(done.scores) == sorted(r.name for r in records)
    for fold in done.folds:
        assert not set(fold.fitted_on) & set(fold.scores)
        assert len(fold.fitted_on) + len(fold.scores) == len(records)
    assert max(s.l1 for s in done.scores.values()) < 0.05
    assert done.failed == {}
    assert plain(done.as_dict()) == plain(done) | {"error": done.error, "relevelled": done.relevelled}


def test_leaving_an_input_out_predicts_only_between_others(records: list[Record]) -> None:
    done = cross_validate(records, "dahl", "input")
    assert sorted(done.scores) == sorted(r.name for r in records if r.voltage in (1.0, 2.0))
    assert len(done.folds) == 2
    assert max(s.l1 for s in done.scores.values()) < 0.05


def test_the_last_part_of_every_motion_is_predicted_from_the_first(records: list[Record]) -> None:
    longer = [r for r in records if r.voltage in (0.0, 1.0)]
    done = cross_validate(longer, "dahl", "time")
    assert sorted(done.scores) == sorted(r.name for r in longer)
    [fold] = done.folds
    assert all("until" in name for name in fold.fitted_on)
    for record in longer:
        said = next(name for name in fold.fitted_on if name.startswith(record.name))
        assert done.scores[record.name].window.start >= float(said.split()[-2]) - 1e-3
    assert max(s.l1 for s in done.scores.values()) < 0.05


def test_one_kind_of_motion_is_predicted_from_the_other(records: list[Record]) -> None:
    damper = Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 90.0, "dahl.rho": 3000.0})
    t = np.arange(0.0, 12.0, 0.005)
    noise = np.random.default_rng(4).normal(size=t.size)
    x = np.convolve(np.cumsum(noise), np.hanning(101), "same")
    x = 0.008 * (x - np.linspace(x[0], x[-1], t.size)) / np.abs(x).max() * np.minimum(t, 1.0)
    force = damper.force(t, x, voltage=0.0)
    broad = Record(time=t, displacement=x, force=force, voltage=0.0, velocity=np.gradient(x, t), name="broad")
    sines = [sine(damper, 0.0, f"s{k}", 0.004 + 0.003 * k, 1.2 - 0.2 * k, noise=0.5, seed=k) for k in range(3)]
    done = cross_validate([broad, *sines], "dahl", "waveform")
    assert [sorted(f.scores) for f in done.folds] == [["broad"], ["s0", "s1", "s2"]]
    assert done.scores["broad"].l1 < 0.05
    with pytest.raises(InputError, match="two kinds of motion"):
        cross_validate(sines, "dahl", "waveform")


def test_what_lies_beyond_the_fitted_records_is_told(records: list[Record]) -> None:
    done = cross_validate(records, "dahl", "amplitude", FitOptions(folds=3))
    warnings_by_record = {name: text for fold in done.folds for name, text in fold.outside.items()}
    assert {name.partition("-")[2] for name in warnings_by_record} == {"2"}
    assert all("displacement reaches 0.008 m" in text for text in warnings_by_record.values())


@pytest.mark.parametrize(
    ("split", "folds", "words"),
    [
        ("weather", 5, "'weather' is an unknown split"),
        ("record", 1, "folds = 1 is not allowed; it must be at least 2"),
        ("record", 99, "99 folds of 12 records"),
    ],
)
def test_wrong_splits_are_refused(records: list[Record], split: str, folds: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        cross_validate(records, "dahl", split, FitOptions(folds=folds))


def test_two_inputs_cannot_be_left_out(records: list[Record]) -> None:
    with pytest.raises(InputError, match="three or more; the records have 2"):
        cross_validate([r for r in records if r.voltage in (0.0, 1.0)], "dahl", "input")


@pytest.mark.prove
def test_folds_repeat_by_seed(records: list[Record]) -> None:
    one, same, other = (cross_validate(records, "dahl", options=FitOptions(folds=3, seed=s)) for s in (1, 1, 2))
    assert [f.fitted_on for f in one.folds] == [f.fitted_on for f in same.folds]
    assert [f.fitted_on for f in one.folds] != [f.fitted_on for f in other.folds]
