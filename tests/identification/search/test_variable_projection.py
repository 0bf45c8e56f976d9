"""The search, which begins on the first part of long records."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search import variable_projection
from dampyr.identification.search.initial_guess import begin
from dampyr.identification.search.normal_equations import linearise
from dampyr.identification.search.problem import Problem
from dampyr.identification.search.variable_projection import Outcome, levenberg_marquardt, more_damping, search
from dampyr.models import Damper

DAHL = Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 55.0, "dahl.rho": 2500.0})


def counted(monkeypatch: pytest.MonkeyPatch, problem: Problem) -> tuple[Outcome, int]:
    """The search and how many samples it evaluated."""
    seen = []
    monkeypatch.setattr(
        variable_projection, "linearise", lambda p, at: seen.append(sum(o.t.size for o in p.pieces)) or linearise(p, at)
    )
    outcome = search(problem, begin(problem))
    return outcome, sum(seen)


@pytest.mark.parametrize("model", ["dahl", "bouc_wen"])
@pytest.mark.prove
def test_a_long_record_is_searched_on_its_first_part_to_the_same_end(
    model: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = prepared(model, [sine(DAHL, 0.0, noise=2.0, seconds=60.0)])
    whole = levenberg_marquardt(problem, begin(problem), None, 1e-12)
    outcome, samples = counted(monkeypatch, problem)
    monkeypatch.setattr(variable_projection, "FIRST_SAMPLES", 10**9)
    plain, all_samples = counted(monkeypatch, problem)
    assert outcome.converged
    assert samples < 0.8 * all_samples
    assert outcome.cost == pytest.approx(plain.cost, rel=1e-7)
    if model == "dahl":
        np.testing.assert_allclose(outcome.point.theta, whole.point.theta, rtol=1e-4)


def test_few_steps_are_few_with_an_opening_too() -> None:
    problem = prepared("dahl", [sine(DAHL, 0.0, noise=2.0, seconds=60.0)])
    iterations: list[int] = []
    outcome = search(problem, begin(problem), lambda k, cost: iterations.append(k), max_iterations=3)
    assert outcome.iterations <= 3
    assert iterations == sorted(iterations)
    assert all(k <= 3 for k in iterations)


def test_a_step_that_was_refused_is_not_evaluated_again() -> None:
    problem = prepared("dahl", [sine(DAHL, 0.0, noise=2.0)])
    here = linearise(problem, begin(problem))
    refused = here.solve(damping=1e-12)
    damping = more_damping(here, refused, 1e-12)
    assert 1e-6 < damping < 1e3  # not 1e-11, whose step is the same
    scale = np.sqrt(np.diag(here.reduced.matrix))

    def change(by: float) -> float:
        return float(np.linalg.norm(scale * (here.solve(damping=by).theta - refused.theta)))

    length = float(np.linalg.norm(scale * refused.theta))
    assert change(damping / 10.0) <= 0.05 * length < change(damping)


def test_a_damping_that_changes_nothing_ends_the_search() -> None:
    problem = prepared("dahl", [sine(DAHL, 0.0, noise=2.0)])
    here = linearise(problem, begin(problem))
    still = replace(here.solve(), theta=np.zeros(3), local=np.zeros((1, problem.locals)))
    assert more_damping(replace(here, sums=np.zeros_like(here.sums)), still, 1.0) > 1e8
