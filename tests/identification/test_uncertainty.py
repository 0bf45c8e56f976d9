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
