"""What the errors are clustered by: records from three on, cycles and no interval below."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t
from tests.identification.synthetic import sine

from dampyr.errors import DampyrWarning
from dampyr.identification import Fit, fit
from dampyr.models import Damper, Interpolation
from dampyr.records import Record, cut

VOLTS = (0.0, 2.0)
TRUTH = Damper(
    "dahl",
    {
        "dahl.kx": Interpolation(VOLTS, (800.0, 1800.0)),
        "dahl.kw": Interpolation(VOLTS, (50.0, 350.0)),
        "dahl.rho": 3000.0,
    },
)


def records(u: float, count: int, gain: float = 0.03) -> list[Record]:
    """Sines at one voltage, the force of each with another gain."""
    rng = np.random.default_rng([int(10 * u), count])
    made = []
    for k in range(count):
        one = sine(TRUTH, u, f"{u:g}V-{k}", rng.uniform(0.004, 0.01), rng.uniform(0.7, 1.4), 1.0, 0.0, seed=k)
        made.append(one.replace(note="another gain", force=(1.0 + gain * rng.standard_normal()) * one.force))
    return made


@pytest.fixture(scope="module")
def mixed() -> Fit:
    """Ten records at 0 V, two at 2 V, and one rho for all."""
    return fit([*records(0.0, 10), *records(2.0, 2)], "dahl", laws={"dahl.rho": "constant"})


@pytest.mark.parametrize("count", [3, 4])
def test_three_records_are_enough_for_errors_by_record(count: int) -> None:
    fit_result = fit(records(2.0, count), "dahl")
    assert fit_result.clusters == "record"
    assert fit_result.within_records == {}
    assert fit_result.freedom["dahl.kw"] == pytest.approx(count - 1, abs=0.5)
    kw, error = fit_result.parameters["dahl.kw"], fit_result.stderr["dahl.kw"]
    assert error == pytest.approx(kw * 0.03 / np.sqrt(count), rel=0.6)
    low, high = fit_result.intervals()["dahl.kw"]
    assert high - low == pytest.approx(2.0 * t.ppf(0.975, fit_result.freedom["dahl.kw"]) * error)
    assert not any("between-record" in note for note in map(str, fit_result.findings))


@pytest.mark.parametrize(("count", "words"), [(1, "1 record:"), (2, "2 records:")])
def test_of_one_or_two_records_the_error_says_that_it_holds_within_them_only(count: int, words: str) -> None:
    fit_result = fit(records(2.0, count), "dahl")
    assert fit_result.clusters == "cycle"
    assert fit_result.within_records == dict.fromkeys(fit_result.parameters, count)
    assert {fit_result.error_holds(name) for name in fit_result.parameters} == {"within these records only"}
    assert all(0.0 < error < np.inf for error in fit_result.stderr.values())
    assert np.all(np.isnan(list(fit_result.intervals().values())))
    [note] = [note for note in map(str, fit_result.findings) if "between-record variance" in note]
    assert note == (
        f"between-record variance is not estimated from {words} the errors hold within these records only and give no 95 % "
        "interval; record 3 or more at this voltage"
    )


def test_each_coefficient_has_clusters_of_its_own(mixed: Fit) -> None:
    assert mixed.clusters == "record and cycle"
    assert mixed.within_records == {"dahl.kx @ 2 V": 2, "dahl.kw @ 2 V": 2}
    assert mixed.freedom["dahl.rho"] > 3.0
    assert mixed.error_holds("dahl.rho") == "between records"
    wide = {name for name, (low, high) in mixed.intervals().items() if np.isfinite(low) and np.isfinite(high)}
    assert wide == {"dahl.kx @ 0 V", "dahl.kw @ 0 V", "dahl.rho"}
    [note] = [note for note in map(str, mixed.findings) if "between-record variance" in note]
    assert "the errors of dahl.kx @ 2 V, dahl.kw @ 2 V hold within" in note
    assert note.endswith("record 3 or more at each voltage")


def test_a_voltage_with_few_records_changes_no_error_of_another() -> None:
    many = records(0.0, 5)
    alone, joint = fit(many, "dahl"), fit([*many, *records(2.0, 2)], "dahl")
    for name in ("dahl.kx", "dahl.kw", "dahl.rho"):
        assert joint.stderr[f"{name} @ 0 V"] == pytest.approx(alone.stderr[name], rel=1e-3)
        assert joint.freedom[f"{name} @ 0 V"] == pytest.approx(alone.freedom[name], rel=1e-3)


def test_the_covariance_of_mixed_clusters_is_one_matrix_to_draw_from(mixed: Fit, tmp_path: Path) -> None:
    assert mixed.damper is not None
    matrix = mixed.damper.covariance
    values = np.linalg.eigvalsh(mixed.correlation)
    assert values.min() > -1e-12
    np.testing.assert_allclose(np.sqrt(np.diag(matrix)), list(mixed.stderr.values()), rtol=1e-12)
    card = mixed.damper.save(tmp_path / "card.toml")
    again = Damper.load(card)
    assert again.within_records == ("dahl.kx @ 2 V", "dahl.kw @ 2 V")
    with pytest.warns(DampyrWarning, match="kx @ 2 V, dahl.kw @ 2 V hold within the fitted records only") as caught:
        drawn = again.draws(400, seed=1, levels=False)
    assert len(caught) == 1
    spread = np.std([one.coefficients for one in drawn], axis=0)
    np.testing.assert_allclose(spread, list(mixed.stderr.values()), rtol=0.15)


def test_a_card_of_enough_records_draws_without_a_warning(tmp_path: Path) -> None:
    fit_result = fit(records(0.0, 4), "dahl")
    assert fit_result.damper is not None
    card = fit_result.damper.save(tmp_path / "card.toml")
    assert "within_records_only" not in card.read_text("utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Damper.load(card).draws(3, seed=1)


def test_what_stands_at_a_limit_or_is_not_determined_is_not_labelled_twice() -> None:
    fixed = {"hyperbolic_tangent.ft": 1e-3, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
    fit_result = fit(
        records(2.0, 1), "dahl + hyperbolic_tangent", laws={"hyperbolic_tangent.c": "constant"}, fixed=fixed
    )
    assert fit_result.stderr["dahl.kx"] == np.inf
    assert fit_result.error_holds("dahl.kx") == ""
    assert "dahl.kx" not in fit_result.within_records
    assert fit_result.within_records["dahl.kw"] == 1


def test_too_few_cycles_are_not_told_as_records_that_determine_nothing() -> None:
    fit_result = fit(sine(TRUTH, 2.0, frequency=0.6, noise=1.0, seconds=4.0), "dahl")
    assert all(np.isinf(list(fit_result.stderr.values())))
    assert any("fewer than 3 cycles determine them" in note for note in map(str, fit_result.findings))
    assert not any("do not determine" in note for note in map(str, fit_result.findings))


def test_the_pieces_of_one_record_are_no_records_of_their_own() -> None:
    """They share its gain, as its cycles do: cutting a record makes no interval that the whole did not give."""
    long = sine(TRUTH, 2.0, "long", noise=2.0, seconds=40.0)
    pieces = cut(long, 8.0)
    assert len(pieces) == 5
    fit_result = fit(pieces, "dahl")
    assert set(fit_result.within_records.values()) == {1}
    assert fit_result.clusters == "cycle"
    others = [piece.replace(note="of its own", provenance={}) for piece in pieces]
    assert fit(others, "dahl").clusters == "record"
    three = [*pieces, *records(2.0, 2)]
    assert fit(three, "dahl").within_records == {}


@pytest.mark.parametrize("seeds", [16, pytest.param(24, marks=pytest.mark.prove)])
def test_errors_with_noise_are_of_the_right_size(seeds: int) -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    numbers, errors = [], []
    for seed in range(seeds):
        fit_result = fit(sine(truth, 0.0, noise=4.0, seed=seed, seconds=12.0), "dahl")
        numbers.append(list(fit_result.parameters.values()))
        errors.append(list(fit_result.stderr.values()))
    ratio = np.std(numbers, axis=0) / np.mean(errors, axis=0)
    assert np.all((ratio > 0.6) & (ratio < 1.7)), ratio
    np.testing.assert_allclose(np.mean(numbers, axis=0), [900.0, 70.0, 2500.0], rtol=0.02)


def test_correlated_residuals_widen_the_errors() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    records = []
    for k in range(12):
        record = sine(truth, 0.0, f"r{k}")
        rng = np.random.default_rng(k)
        gain = 1.0 + 0.05 * rng.standard_normal()
        records.append(record.replace(note="another gain", force=record.force * gain))
    fit_result = fit(records, "dahl")
    assert fit_result.clusters == "record"
    assert fit_result.stderr["dahl.kw"] > 5 * fit_result.naive_stderr["dahl.kw"]
    assert fit_result.stderr["dahl.kw"] == pytest.approx(70.0 * 0.05 / np.sqrt(12), rel=0.5)


def test_what_the_records_do_not_determine_has_an_infinite_error() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fixed = {"hyperbolic_tangent.ft": 1e-3, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
    laws = {"hyperbolic_tangent.c": "constant"}
    fit_result = fit(sine(truth, 0.0, noise=1.0), "dahl + hyperbolic_tangent", fixed=fixed, laws=laws)
    assert fit_result.stderr["dahl.kx"] == np.inf
    assert fit_result.stderr["hyperbolic_tangent.c"] == np.inf
    assert np.isfinite(fit_result.stderr["dahl.kw"])
    assert any("do not determine" in note for note in map(str, fit_result.findings))


def test_a_record_without_reversal_does_not_give_rho() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    t = np.arange(0.0, 5.0, 0.01)
    x = 0.004 * t
    v = np.full(t.size, 0.004)
    force = truth.force(t, x, voltage=0.0, velocity=v, state0=[1.0])
    record = Record(t, x, force + np.random.default_rng(0).normal(0, 1, t.size), velocity=v, voltage=0.0)
    fit_result = fit(record, "dahl")
    assert not np.isfinite(fit_result.stderr["dahl.rho"])


def test_clustered_errors_are_those_of_the_mean_of_independent_records() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    gains = 1.0 + 0.02 * np.array([-1.3, 0.4, 0.9, -0.2, 1.6, -1.4])
    records = []
    for k, gain in enumerate(gains):
        record = sine(truth, 0.0, f"r{k}", offset=0.0)
        records.append(record.replace(note="another gain", force=record.force * gain))
    fixed = {"dahl.kx": 0.0, "dahl.rho": 2500.0}
    pure = [
        r.replace(note="friction only", force=(r.force - gain * 900.0 * r.velocity))
        for r, gain in zip(records, gains, strict=True)
    ]
    fit_result = fit(pure, "dahl", fixed=fixed)
    assert fit_result.clusters == "record"
    assert fit_result.stderr["dahl.kw"] == pytest.approx(70.0 * np.std(gains, ddof=1) / np.sqrt(gains.size), rel=0.03)


def test_errors_pay_for_the_offset() -> None:
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 20.0, 0.01)
    x = 0.05 + 0.01 * np.sin(2 * np.pi * t)
    force = 4000.0 * x + rng.normal(0.0, 2.0, t.size)
    fit_result = fit(Record(t, x, force, velocity=np.gradient(x, t), voltage=0.0), "spring")
    exact = 2.0 / np.sqrt(np.sum((x - x.mean()) ** 2))
    assert fit_result.naive_stderr["spring.k0"] == pytest.approx(exact, rel=0.06)
    assert fit_result.parameters["spring.k0"] == pytest.approx(4000.0, abs=4 * exact)
