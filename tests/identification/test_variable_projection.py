"""The search, which begins on the first part of long records."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import variable_projection
from dampyr.identification.fit import prepared
from dampyr.identification.fit_data import first_part
from dampyr.identification.initial_guess import begin
from dampyr.identification.normal_equations import linearise
from dampyr.identification.problem import Problem
from dampyr.identification.variable_projection import Outcome, levenberg_marquardt, search
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


def test_the_first_part_holds_the_motion_or_it_is_the_whole() -> None:
    one = prepared("dahl", [sine(DAHL, 0.0, seconds=60.0)]).pieces[0]
    assert first_part(one, 1500).t.size == 1500
    growing = replace(one, x=one.x * np.linspace(0.0, 1.0, one.t.size), v=one.v * np.linspace(0.0, 1.0, one.t.size))
    assert first_part(growing, 1500).t.size == growing.t.size
    late = replace(one, x=np.where(one.t < 20.0, 0.1 * one.x, one.x), v=np.where(one.t < 20.0, 0.1 * one.v, one.v))
    assert first_part(late, 1500).t.size == 6000


def test_few_steps_are_few_with_an_opening_too() -> None:
    problem = prepared("dahl", [sine(DAHL, 0.0, noise=2.0, seconds=60.0)])
    iterations: list[int] = []
    outcome = search(problem, begin(problem), lambda k, cost: iterations.append(k), max_iterations=3)
    assert outcome.iterations <= 3
    assert iterations == sorted(iterations)
    assert all(k <= 3 for k in iterations)
