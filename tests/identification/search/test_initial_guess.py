"""Where searches begin: one start and several."""

import numpy as np
import pytest
from tests.identification.fitted_numbers import values
from tests.identification.synthetic import DAHL, sine

from dampyr.identification import fit
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search.initial_guess import begin
from dampyr.identification.search.variable_projection import search
from dampyr.models import Damper, Interpolation
from dampyr.models.part import Scale, part


@pytest.mark.parametrize("volts", [(0.0,), (0.0, 2.0)])
def test_a_search_begins_with_the_proposal_nearest_to_the_truth_at_each_input(volts: tuple[float, ...]) -> None:
    """The proposals of rho go by factors of three or so; what is linear the first step of the search finds, from 0."""
    truth = {"dahl.kx": (900.0, 2400.0), "dahl.kw": (70.0, 300.0), "dahl.rho": (2500.0, 2500.0)}
    damper = Damper("dahl", {name: Interpolation((0.0, 2.0), values) for name, values in truth.items()})
    problem = prepared("dahl", [sine(damper, u, f"{u:g}V", offset=120.0) for u in volts])
    point = begin(problem)
    stroke = max(float(np.ptp(one.x)) for one in problem.pieces)
    speed = max(float(np.abs(one.v).max()) for one in problem.pieces)
    proposed = [one["rho"] for one in part("dahl").starts(Scale(stroke, speed, 0.005, 100.0))]
    nearest = min(proposed, key=lambda rho: abs(np.log(rho / 2500.0)))
    n = len(volts)
    np.testing.assert_allclose(point.theta[2 * n :], nearest, rtol=0.01)
    np.testing.assert_allclose(point.theta[: 2 * n], 0.0, atol=1e-6)
    np.testing.assert_array_equal(problem.inside(point.theta), point.theta)
    np.testing.assert_allclose(point.local[:, 0], [np.mean(one.force) for one in problem.pieces])  # the offsets


def test_parts_behind_what_stretches_begin_where_they_end_without_it() -> None:
    record = sine(DAHL, 0.0)
    rigid, soft = prepared("dahl", [record]), prepared("dahl + compliance", [record])
    point = begin(soft)
    np.testing.assert_allclose(point.theta[:3], search(rigid, begin(rigid)).point.theta, rtol=0.01)
    assert 0.0 < point.theta[3] * 1000.0 < 0.1 * np.ptp(record.displacement)  # of a kilonewton


TWO_MINIMA = {
    "maxwell_slip": {"kx": 252.5, "kw": 74.44, "rho": 311.0},
    "hysteretic_biviscous": {"c": 143.4, "fy": 58.45, "vy": 0.02111, "vh": 0.02627},
}


@pytest.mark.prove
@pytest.mark.parametrize("model", TWO_MINIMA)
def test_several_starts_find_the_lower_of_two_minima(model: str) -> None:
    truth = {f"{model}.{name}": value for name, value in TWO_MINIMA[model].items()}
    record = sine(Damper(model, truth), 0.0, amplitude=0.008, noise=0.3, seconds=5.0)
    one, many = fit(record, model), fit(record, model, starts=8, seed=0)
    assert one.outcome.cost > 2 * many.outcome.cost
    np.testing.assert_allclose(values(many), list(truth.values()), rtol=0.05)
    assert many.starts[0] == 8
    assert 1 <= many.starts[1] < 8
    assert any("of 8 starts ended in the same optimum" in note for note in map(str, many.findings))
    assert fit(record, model, starts=8, seed=0).parameters == many.parameters


@pytest.mark.prove
def test_several_starts_are_never_worse_than_one() -> None:
    """Behind free play the start of one is that of the rigid damper, which was not among several: they ended at 26 %."""
    truth = {"dahl.kx": 2400.0, "dahl.kw": 900.0, "dahl.rho": 7000.0, "free_play.g": 7e-4, "free_play.fc": 18.0}
    record = sine(Damper("dahl + free_play", truth), 0.0, amplitude=0.005, noise=1.0, seconds=5.0)
    one, many = fit(record, "dahl + free_play"), fit(record, "dahl + free_play", starts=3)
    assert many.outcome.cost <= 1.0001 * one.outcome.cost


def test_all_starts_of_a_plain_problem_agree() -> None:
    fit_result = fit(sine(DAHL, 0.0, noise=1.0), "dahl", starts=6)
    assert fit_result.starts == (6, 6)
    np.testing.assert_allclose(values(fit_result), values(fit(sine(DAHL, 0.0, noise=1.0), "dahl")), rtol=1e-4)
