"""A force that went through a moving average: the model's goes through the same in fit, score, prediction and acceptance."""

import warnings

import numpy as np
import pytest
from tests.identification.search.test_normal_equations import DAHL, LAWS, numeric, somewhere
from tests.identification.smoothed_records import SAMPLES, records, smoothed
from tests.identification.synthetic import sine

from dampyr.identification import FitOptions, accept, fit, score, validate
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.scoring.score import prediction
from dampyr.identification.scoring.validation import cross_validate
from dampyr.identification.search.normal_equations import products
from dampyr.models import Constant, Damper, WithTemperature
from dampyr.records import MovingAverage
from dampyr.records.checks.quality import motion_start

CASES = {
    "dahl": ("dahl", {}),
    "gain, temperature": ("dahl", {"nuisances": ("offset", "state", "gain", "temperature")}),
    "delay": ("dahl + delay", {}),
}


@pytest.mark.parametrize("trailing", [False, True], ids=["centred", "trailing"])
@pytest.mark.parametrize("case", [pytest.param(k, marks=pytest.mark.prove if k == "delay" else ()) for k in CASES])
def test_the_sums_are_those_of_the_averaged_derivatives(case: str, trailing: bool) -> None:
    """Against central differences of the modelled force, over whole windows only."""
    model, options = CASES[case]
    given = [smoothed(record, SAMPLES + r, trailing) for r, record in enumerate(records(2.0))]
    problem = prepared(model, given, FitOptions(**options))
    point = somewhere(problem)
    for r, one in enumerate(problem.pieces):
        table = numeric(problem, point, r)
        outside = np.ones(one.t.size, dtype=bool)
        outside[one.comparable] = False
        assert outside.sum() == SAMPLES + r - 1
        table[outside] = 0.0
        sums = products(problem, point)[r].sum(axis=0)
        np.testing.assert_allclose(sums, table.T @ table, rtol=2e-4, atol=2e-5 * np.abs(table.T @ table).max())


def test_an_input_that_varies_goes_through_the_average_too() -> None:
    damper = Damper("dahl", LAWS)
    record = sine(damper, 1.0, "a", noise=1.0)
    record = smoothed(record.replace(note="", voltage=1.0 + np.sin(record.time)))
    problem = prepared("dahl", [record], FitOptions(laws="polynomial:1"))
    point = somewhere(problem)
    table = numeric(problem, point, 0)
    part = problem.pieces[0].comparable
    table = table[part]
    np.testing.assert_allclose(
        products(problem, point)[0].sum(axis=0), table.T @ table, rtol=2e-4, atol=2e-5 * np.abs(table.T @ table).max()
    )


def test_the_parameters_behind_a_smoothed_force_and_those_of_a_fit_that_ignores_it() -> None:
    truth = {"dahl.kx": 800.0, "dahl.kw": 55.0, "dahl.rho": 2500.0}
    made = [sine(DAHL, 0.0, f"{k}", 0.004 + 0.003 * k, 1.0 - 0.2 * k, seed=k) for k in range(3)]
    fitted = fit([smoothed(record) for record in made], "dahl")
    assert fitted.converged
    assert {k.partition(" @")[0]: v for k, v in fitted.parameters.items()} == pytest.approx(truth, rel=1e-5)
    assert max(one.l1 for one in fitted.scores.values()) < 1e-5
    assert fitted.residuals.whole.rms < 1e-4
    [note] = [note for note in map(str, fitted.findings) if "moving average" in note]
    assert note.startswith("the measured force of 0, 1, 2 is smoothed")
    ignored = fit([smoothed(record).replace(note="", smoothed=None) for record in made], "dahl")
    values = {k.partition(" @")[0]: v for k, v in ignored.parameters.items()}
    assert abs(values["dahl.rho"] / 2500.0 - 1.0) > 0.05


def test_a_robust_loss_and_several_starts() -> None:
    made = [smoothed(record) for record in records(2.0)]
    spoilt = made[0].force.copy()
    spoilt[300:310] += 400.0
    made[0] = made[0].replace(note="", force=spoilt)
    options = {"fixed": {}, "laws": "interpolation"}
    assert fit(made, "dahl", loss="huber", starts=2, **options).parameters["dahl.kw @ 2 V"] == pytest.approx(
        380, rel=0.02
    )


def test_the_prediction_is_averaged_and_partial_windows_are_not_scored() -> None:
    record = sine(DAHL, 0.0, "a")
    averaged = smoothed(record)
    before = after = SAMPLES // 2
    predicted = prediction(DAHL, averaged)
    whole = prediction(DAHL, record)
    i = 700
    assert predicted[i] == pytest.approx(np.mean(whole[i - before : i + after + 1]))
    made = score(DAHL, averaged)
    assert made.l1 < 1e-9
    assert made.window.last == record.n - 1 - after
    assert score(DAHL, averaged, settling=-5.0).window.first == before
    assert score(DAHL, averaged.replace(note="", smoothed=None)).l1 > 0.02
    assert validate(DAHL, [averaged]).scores["a"].l1 < 1e-9


def test_the_score_of_a_record_at_its_temperature_from_any_centre_and_settling() -> None:
    """The mean of the force at the record's temperature over each window, by brute force; whole windows only."""
    law = {
        "dahl.kx": WithTemperature(Constant(900.0), Constant(600.0), (15.0, 45.0)),
        "dahl.kw": 70.0,
        "dahl.rho": 2500.0,
    }
    damper = Damper("dahl", law)
    record = sine(damper.at_temperature(30.0), 0.0, "a").replace(note="", temperature=np.full(1200, 30.0))
    averaged = smoothed(record)
    for centre in ("quantiles", "midrange"):
        for settling in (0.0, 0.5, 2.0):
            made = score(damper, averaged, settling=settling, centre=centre)  # type: ignore[arg-type]
            assert made.l1 < 1e-9
            assert made.window.last == record.n - 1 - SAMPLES // 2
            assert made.window.first >= SAMPLES // 2
    warmer = averaged.replace(note="", temperature=record.temperature + 10.0)
    assert score(damper, warmer).l1 > 0.01


@pytest.mark.parametrize("loss", ["huber", pytest.param("l1", marks=pytest.mark.prove)])
def test_what_has_no_whole_window_has_no_part_in_a_robust_loss(loss: str) -> None:
    """Whatever stands in the first and last half window, the fit and its errors are the same."""
    made = [smoothed(record) for record in records(2.0)]
    first = [int(np.searchsorted(record.time, motion_start(record))) for record in made]
    spoilt = []
    for record, at in zip(made, first, strict=True):
        force = record.force.copy()
        force[-(SAMPLES // 2) :] += 30.0
        force[at : at + SAMPLES // 2] -= 30.0
        spoilt.append(record.replace(note="", force=force))
    one, other = (fit(each, "dahl", loss=loss) for each in (made, spoilt))
    assert one.converged
    assert other.converged
    assert other.parameters == pytest.approx(one.parameters, rel=1e-4)
    assert other.stderr == pytest.approx(one.stderr, rel=1e-3)
    assert other.naive_stderr == pytest.approx(one.naive_stderr, rel=1e-3)


def test_a_record_that_is_too_short_to_settle_is_scored_over_whole_windows_of_its_motion() -> None:
    record = smoothed(sine(DAHL, 0.0, "short", seconds=2.4))
    longer = smoothed(sine(DAHL, 0.0, "long", 0.006))
    fitted = fit([longer, record], "dahl")
    at = fitted.scores["short"].window
    assert at.last == record.n - 1 - SAMPLES // 2
    assert at.first == int(np.searchsorted(record.time, motion_start(record))) + SAMPLES // 2
    assert fitted.scores["short"].l1 < 1e-4


def test_cross_validation_and_acceptance_compare_like_with_like() -> None:
    made = [smoothed(record) for record in records(0.5, count=3)]
    assert cross_validate(made, "dahl", options=FitOptions(folds=3)).error < 0.02
    damper = Damper("dahl", LAWS)
    assert accept(made[0], damper).verdict == "passed"
    far = smoothed(records(0.5)[0], 41)
    judged = accept(made[0], [far.replace(note="", name="reference")]).results[0]
    assert judged.passed is None
    assert "the force here is smoothed over 0.105 s, that of the reference otherwise" in judged.reasons
    again = smoothed(sine(damper, 0.0, "again", 0.004, 1.0, 0.5, seed=9))
    assert accept(made[0], [again]).results[0].judged
    plain = accept(records(0.5)[0], [again]).results[0]
    assert "the force here is not smoothed, that of the reference otherwise" in plain.reasons


def test_a_smoothed_displacement_is_told_in_the_notes() -> None:
    made = [smoothed(record, motion=True) for record in records(1.0)]
    fitted = fit(made, "dahl")
    [note] = [note for note in map(str, fitted.findings) if "less sharp" in note]
    assert "is smoothed (over up to 0.105 s) and that is not undone" in note


def test_ordinary_records_take_the_compiled_sums(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored for them, whatever else is fitted with them."""
    from dampyr.identification.search import normal_equations

    stored = []
    original = normal_equations._sum_stored

    def counting(problem: object, one: object, *rest: object) -> object:
        stored.append(one.name)  # type: ignore[attr-defined]
        return original(problem, one, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(normal_equations, "_sum_stored", counting)
    plain, other, *_ = records(1.0)
    problem = prepared("dahl", [plain, smoothed(other)], FitOptions(laws="constant"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        products(problem, somewhere(problem))
    assert stored == [other.name]


def test_the_average_stays_with_a_record_that_is_cut() -> None:
    record = smoothed(records()[0])
    assert record.until(3.0).smoothed == MovingAverage(0.105, "centred", ("force",))
