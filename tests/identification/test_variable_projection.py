"""The compiled algebra of a search against numpy, and a search that begins on the first part of long records."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import variable_projection
from dampyr.identification.bounded_least_squares import solve_bounded, solve_by_cholesky, solve_by_eigenvalues
from dampyr.identification.fit import prepared
from dampyr.identification.fit_data import first_part
from dampyr.identification.initial_guess import begin
from dampyr.identification.normal_equations import NormalEquations, Step, linearise, step_point
from dampyr.identification.problem import Problem
from dampyr.identification.variable_projection import Outcome, levenberg_marquardt, search
from dampyr.models import Damper
from dampyr.models.codegen.kernels import compile_cached

DAHL = Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 55.0, "dahl.rho": 2500.0})
FREE = np.ones(6, dtype=bool)


def normal_equations(seed: int, twins: float = 1.0) -> np.ndarray:
    """J'J beside J'r, of columns of very different sizes; the last two differ by ``twins``."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(40, 6)) * 10.0 ** rng.uniform(-3, 3, 6)
    J[:, 5] = J[:, 4] + twins * J[:, 5] / np.linalg.norm(J[:, 5]) * np.linalg.norm(J[:, 4])
    return np.column_stack((J.T @ J, J.T @ rng.normal(size=40)))


def factors(S: np.ndarray) -> tuple[bool, np.ndarray]:
    x = np.empty(6)
    done = compile_cached(solve_by_cholesky)(S[:, :6].copy(), S[:, 6].copy(), FREE, np.empty(6), np.empty((6, 6)), x)
    return done, x


def test_factors_give_what_eigenvalues_give() -> None:
    for seed in range(20):
        S = normal_equations(seed)
        done, x = factors(S)
        assert done
        np.testing.assert_allclose(x, solve_by_eigenvalues(S[:, :6], S[:, 6]), rtol=1e-8)


def test_a_near_singular_matrix_is_left_to_eigenvalues() -> None:
    S = normal_equations(0, twins=1e-8)
    assert not factors(S)[0]
    step = solve_bounded(S, 0.0, np.full(6, -np.inf), np.full(6, np.inf), FREE)
    np.testing.assert_allclose(step, solve_by_eigenvalues(S[:, :6], S[:, 6]), rtol=1e-9)
    assert np.max(np.abs(step[4:] * np.sqrt(np.diag(S)[4:]))) < 10.0


def test_unknowns_that_are_not_chosen_stay() -> None:
    S, chosen = normal_equations(3), np.array([True, False, True, True, False, True])
    step = solve_bounded(S, 0.0, np.full(6, -np.inf), np.full(6, np.inf), chosen)
    assert np.all(step[~chosen] == 0.0)
    np.testing.assert_allclose((S[:, :6] @ step)[chosen], S[chosen, 6], rtol=1e-9)


def test_gain_and_what_is_left_are_those_of_the_quadratic() -> None:
    rng = np.random.default_rng(1)
    tables = [rng.normal(size=(30, 6)) for _ in range(3)]  # two nuisances, three coefficients, the residual
    sums = np.stack([table.T @ table for table in tables])
    nothing = np.zeros(3, dtype=bool)
    here = NormalEquations(sums, nothing, nothing[:2], *np.zeros((2, 3)), np.zeros((3, 2)), np.zeros((3, 2)))
    step = Step(rng.normal(size=3), rng.normal(size=(3, 2)))
    left = [a[:, 5] - a[:, :5] @ np.concatenate((d, step.theta)) for a, d in zip(tables, step.local, strict=True)]
    cost = 0.5 * sum(float(r @ r) for r in left)
    there = here.after(step)
    assert there.cost == pytest.approx(cost, rel=1e-12)
    assert here.reduction(step) == pytest.approx(here.cost - cost, rel=1e-12)
    for k in range(3):
        np.testing.assert_allclose(there.sums[k, :5, 5], tables[k][:, :5].T @ left[k], rtol=1e-10, atol=1e-10)


def test_a_step_of_a_logarithm_is_a_factor() -> None:
    problem = prepared("dahl", [sine(DAHL, 0.0, noise=1.0)])
    point = begin(problem)
    moved_on = step_point(problem, point, Step(np.array([3.0, -4.0, 0.5]), np.zeros((1, 2))))
    np.testing.assert_allclose(moved_on.theta, point.theta * [1, 1, np.exp(0.5)] + [3.0, 0.0, 0.0], atol=1e-8)
    assert moved_on.theta[1] >= 0.0


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
