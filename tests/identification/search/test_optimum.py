"""What is known at the end of a search: worked out once, and the same as when it is worked out anew."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.identification.campaign_of_dahl import VOLTS, campaign
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import Fit, fit, identifiability, profile
from dampyr.identification.search import normal_equations as equations
from dampyr.identification.search import optimum
from dampyr.identification.search.normal_equations import linearise, modelled_force
from dampyr.identification.search.problem import SearchPoint
from dampyr.models import Damper, Interpolation
from dampyr.show.pages.result_page import write_page

DAHL: dict[str, float | Interpolation] = {
    "dahl.kx": 900.0,
    "dahl.kw": Interpolation(VOLTS, (50.0, 210.0, 380.0, 560.0)),
    "dahl.rho": 2500.0,
}
#: a loop that is nearly viscous: c and kw trade against each other, so a page proposes tests
LOOP = Damper(
    "bouc_wen",
    {
        "bouc_wen.c0": Interpolation(VOLTS, (600.0, 900.0, 1300.0, 1700.0)),
        "bouc_wen.k0": 900.0,
        "bouc_wen.kw": Interpolation(VOLTS, (60.0, 200.0, 400.0, 600.0)),
        "bouc_wen.rho": 700.0,
        "bouc_wen.sigma": 1.2,
        "bouc_wen.n": 1.3,
    },
)


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> dict[str, list[int]]:
    """The sizes, in records, of the problems whose derivatives or forces are worked out, wherever that is called from."""
    seen: dict[str, list[int]] = {"products": [], "modelled_force": []}

    def counted(name: str, function: Callable[..., object]) -> Callable[..., object]:
        def call(problem, *rest, **more):  # type: ignore[no-untyped-def]
            seen[name].append(len(problem.pieces))
            return function(problem, *rest, **more)

        return call

    for name in seen:
        function = getattr(equations, name)
        for module in (equations, optimum, sys.modules["dampyr.identification.parameter_uncertainty.identifiability"]):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, counted(name, function))
    return seen


@pytest.mark.prove
def test_a_page_of_a_fit_linearises_nothing_but_the_tests_that_it_proposes(
    tmp_path: Path, calls: dict[str, list[int]]
) -> None:
    fitted = fit(campaign(LOOP, noise=10.0, per_voltage=3), "bouc_wen")
    assert any(one.kind == "pair" for one in identifiability(fitted).inseparable)
    for some in calls.values():
        some.clear()
    write_page(fitted, tmp_path / "fit.html")
    assert len(calls["products"]) == 1  # the floor: below 10
    assert calls["products"][0] > 100  # all tests that could be proposed, at all voltages, together
    assert len(fitted.records) not in calls["modelled_force"]  # the forces of the fit are those of its optimum


def test_what_records_cannot_separate_is_worked_out_with_one_linearisation_of_the_tests(
    calls: dict[str, list[int]],
) -> None:
    fitted = fit(campaign(Damper("dahl", DAHL), noise=20.0), "dahl")
    for some in calls.values():
        some.clear()
    assert identifiability(fitted).inseparable
    assert len(calls["products"]) <= 1
    assert len(fitted.records) not in calls["products"] + calls["modelled_force"]


def test_a_fit_works_its_forces_and_derivatives_out_once_at_its_end(calls: dict[str, list[int]]) -> None:
    fitted = fit(campaign(Damper("dahl", DAHL), noise=20.0), "dahl")
    assert calls["modelled_force"].count(len(fitted.records)) == len(fitted.records)
    assert calls["products"][-1] == len(fitted.records)  # by cluster, once
    end = len(calls["products"])
    assert fitted.optimum.information.shape == (12, 12)
    for label in list(fitted.parameters)[:2]:
        profile(fitted, label, points=5)
    assert len(fitted.records) not in calls["products"][end:]
    assert calls["modelled_force"].count(len(fitted.records)) == len(fitted.records)


@pytest.mark.parametrize("loss", ["squares", "huber"])
def test_the_blocks_of_an_optimum_are_what_they_would_be_alone(loss: str) -> None:
    fitted = fit(campaign(Damper("dahl", DAHL), noise=20.0, per_voltage=3), "dahl", loss=loss)
    whole = fitted.optimum
    assert len(whole.blocks) == len(VOLTS)
    assert sorted(place for block in whole.blocks for place in block.places) == list(range(whole.problem.size))
    for block in whole.blocks:
        alone = optimum.Optimum(block.problem, block.point)
        for mine, other in zip(block.cluster_sums, alone.cluster_sums, strict=True):
            np.testing.assert_allclose(mine, other, rtol=1e-11, atol=1e-11 * np.abs(other).max())
        for mine, other in zip(block.curvature_sums, alone.curvature_sums, strict=True):
            np.testing.assert_allclose(mine, other, rtol=1e-11, atol=1e-11 * np.abs(other).max())
        for mine, other in zip(block.forces, alone.forces, strict=True):
            np.testing.assert_allclose(mine, other, rtol=1e-12)
        np.testing.assert_allclose(block.information, alone.information, rtol=1e-9)
    assert (whole.curvature_sums is whole.cluster_sums) == (loss == "squares")


def fits_with_priors() -> Fit:
    truth = Damper("dahl", DAHL)
    records = [sine(truth, u, f"{u}-{k}", 0.005 + 0.002 * k, noise=5.0, seed=k) for u in (0.0, 2.0) for k in range(3)]
    return fit(records, "dahl", nuisances=("offset", "gain", "state"))


@pytest.mark.parametrize("make", [fits_with_priors, lambda: fit(campaign(Damper("dahl", DAHL), noise=20.0), "dahl")])
def test_the_equations_of_an_optimum_are_those_of_a_linearisation_there(make: Callable[[], Fit]) -> None:
    end = make().optimum
    anew = linearise(end.problem, end.point)
    np.testing.assert_allclose(end.equations.sums, anew.sums, rtol=1e-10, atol=1e-12 * np.abs(anew.sums).max())
    np.testing.assert_allclose(
        end.information, anew.reduced.matrix, rtol=1e-9, atol=1e-12 * np.abs(end.information).max()
    )
    for name in ("low", "high", "local_low", "local_high"):
        np.testing.assert_array_equal(getattr(end.equations, name), getattr(anew, name))


def test_the_derivatives_in_an_optimum_are_those_of_its_forces() -> None:
    end = fit(campaign(Damper("dahl", DAHL), noise=20.0, per_voltage=2), "dahl", laws="polynomial:1").optimum
    problem, place = end.problem, 1
    step = 1e-6 * abs(float(end.point.theta[place]))
    theta = end.point.theta + step * (np.arange(problem.size) == place)
    for r, piece in enumerate(problem.pieces):
        slope = (modelled_force(problem, SearchPoint(theta, end.point.local), r) - end.forces[r]) / step
        gradient = float(np.sum(piece.weight**2 * slope * end.residuals[r]))
        square = float(np.sum(piece.weight**2 * slope**2))
        sums = end.cluster_sums[r].sum(axis=0)
        column = problem.locals + place
        assert sums[column, column] == pytest.approx(square, rel=1e-4)
        assert sums[column, -1] == pytest.approx(gradient, rel=1e-4, abs=1e-4 * np.sqrt(square))


def test_the_law_matrix_takes_the_fitted_numbers_to_the_coefficients_of_the_damper() -> None:
    laws = {"dahl.kx": "polynomial:2", "dahl.rho": "constant"}
    fitted = fit(campaign(Damper("dahl", DAHL), noise=5.0), "dahl", laws=laws, fixed={"dahl.rho": 2500.0})
    assert fitted.damper is not None
    np.testing.assert_allclose(fitted.optimum.law_coefficients(fitted.optimum.point.theta), fitted.damper.coefficients)
    theta = fitted.optimum.point.theta
    (stronger,) = fitted.optimum.draw_dampers(1, fitted.damper, lambda: 1.1 * theta, "")
    assert stronger.all_laws["dahl.kw"](2.0) == pytest.approx(1.1 * float(fitted.damper.all_laws["dahl.kw"](2.0)))
    with pytest.raises(InputError, match="only 0 of 100 draws were admissible; they are negative"):
        fitted.optimum.draw_dampers(1, fitted.damper, lambda: -theta, "; they are negative")
