"""The dissertation's two methods on records, each with its error beside least squares."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.identification.synthetic import sine

import dampyr as dp
from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.identification import Score, compare_method, plastic_region
from dampyr.identification.limit_cycle_methods.method_comparison import METHODS, loading_branch
from dampyr.models import Damper
from dampyr.records import Record, with_velocity

NUMBERS = {"kx": 900.0, "kw": 70.0, "rho": 2500.0}
DAHL = Damper("dahl", NUMBERS)


@pytest.mark.parametrize(("method", "share"), [("limit-cycle", 0.06), ("plastic-region", 0.15)])
def test_the_numbers_of_a_clean_loop_come_back_and_least_squares_are_better(method: str, share: float) -> None:
    comparison = compare_method(sine(DAHL, 0.0), method)
    [result] = comparison.results
    assert result.numbers["kx"] == pytest.approx(900.0, rel=0.02)
    assert result.numbers["kw"] == pytest.approx(70.0, rel=share)
    assert result.numbers["rho"] == pytest.approx(2500.0, rel=share)
    assert isinstance(result.score, Score)
    assert isinstance(result.least_squares_score, Score)
    assert result.least_squares_score.l1 < 1e-6 < result.score.l1 < 0.05
    assert result.least_squares == pytest.approx(NUMBERS, rel=1e-4)
    assert f"MethodComparison {method!r}" in repr(comparison)


def test_the_numbers_of_the_plastic_region_are_those_of_its_own_call() -> None:
    record = sine(DAHL, 0.0, noise=1.0)
    [result] = compare_method([record], "plastic-region").results
    single = plastic_region(record)
    assert result.numbers == {"kx": single.kx, "kw": single.kw, "rho": single.rho}


def test_the_loading_branch_is_the_mean_of_the_cycles() -> None:
    """Noise of the force falls with the number of cycles; the branch rises from one turning point to the other."""
    clean, noisy = (with_velocity(sine(DAHL, 0.0, noise=noise, seconds=20.0), None) for noise in (0.0, 8.0))
    x, force, velocity = loading_branch(noisy)
    assert np.all(np.diff(x) > 0.0)
    assert (x[0], x[-1]) == pytest.approx((clean.displacement.min(), clean.displacement.max()), rel=0.01)
    assert np.mean(velocity > 0.0) > 0.98
    middle = slice(x.size // 4, -x.size // 4)
    assert np.std(force[middle] - np.interp(x, *loading_branch(clean)[:2])[middle]) < 8.0 / np.sqrt(15)


def test_what_a_record_does_not_give_is_a_reason() -> None:
    t = np.linspace(0.0, 5.0, 1001)
    x = 0.01 * np.sin(2 * np.pi * t)
    lifted = Record(t, x, 200.0 * np.sin(2 * np.pi * t + 0.5), voltage=0.0, name="no friction")
    comparison = compare_method([sine(DAHL, 0.0), lifted], "limit-cycle")
    first, second = comparison.results
    assert isinstance(first.score, Score)
    assert isinstance(second.score, str)
    assert second.score
    assert comparison.as_dict()["results"][1]["score"] == {"problem": second.score}
    with pytest.raises(InputError, match=r"method = 'by eye' is not known; .*choose from limit-cycle, plastic-region"):
        compare_method([sine(DAHL, 0.0)], "by eye")
    with pytest.raises(InputError, match="there are no records"):
        compare_method([], "limit-cycle")


@pytest.mark.parametrize(
    "method", [pytest.param(m, marks=[] if m == "limit-cycle" else [pytest.mark.prove]) for m in METHODS.words]
)
def test_the_command_shows_both(tmp_path: Path, method: str) -> None:
    dp.records.write(sine(DAHL, 0.0), tmp_path / "a.csv")
    done = CliRunner().invoke(cli, ["identify", str(tmp_path), "--method", method])
    assert done.exit_code == 0, done.output
    assert f"by the method {method}, beside least squares" in done.stdout
    data = json.loads(CliRunner().invoke(cli, ["identify", str(tmp_path), "--method", method, "--json"]).stdout)
    assert set(data["results"][0]["numbers"]) == {"kx", "kw", "rho"}
    refused = CliRunner().invoke(cli, ["identify", str(tmp_path), "--method", "limit-cycle", "--save", "card.toml"])
    assert refused.exit_code == 2
    assert "leave out --model, --each, --by-specimen, --save and --report" in refused.output


@pytest.mark.prove
def test_on_the_published_campaign_they_are_worse_than_least_squares(published_fit_records: list[Record]) -> None:
    """What docs/explanations/identification.md says of them."""
    records = published_fit_records
    means, given = {}, {}
    for method in METHODS.words:
        results = compare_method(records, method).results
        l1 = [result.score.l1 for result in results if isinstance(result.score, Score)]
        means[method], given[method] = float(np.mean(l1)), len(l1)
        least = float(np.mean([r.least_squares_score.l1 for r in results if isinstance(r.least_squares_score, Score)]))
        assert least == pytest.approx(0.106, abs=0.002)
    assert means["plastic-region"] == pytest.approx(0.145, abs=0.002)
    assert given["plastic-region"] == 38
    assert given["limit-cycle"] < 20
    assert means["limit-cycle"] > 0.3
