"""The sums that the kernel takes, the elimination of nuisances and the search, against dense linear algebra and scipy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from tests.identification.synthetic import sine

from dampyr.identification import FitOptions, fit
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search.initial_guess import begin
from dampyr.identification.search.normal_equations import (
    NormalEquations,
    SearchStep,
    eliminated,
    linearise,
    modelled_force,
    products,
    step_point,
)
from dampyr.identification.search.problem import Problem, SearchPoint, independent_blocks
from dampyr.identification.search.variable_projection import levenberg_marquardt, search
from dampyr.models import Damper, Interpolation
from dampyr.records import Record

VOLTS = (0.0, 2.0)
DAHL = Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 55.0, "dahl.rho": 2500.0})
LAWS = {
    "dahl.kx": Interpolation(VOLTS, (800.0, 2500.0)),
    "dahl.kw": Interpolation(VOLTS, (50.0, 380.0)),
    "dahl.rho": Interpolation(VOLTS, (4000.0, 1800.0)),
}


def records(noise: float = 2.0) -> list[Record]:
    damper = Damper("dahl", LAWS)
    return [
        sine(damper, u, f"{u:g}-{k}", 0.004 + 0.003 * k, 1.0 - 0.2 * k, noise, seed=k) for u in VOLTS for k in range(3)
    ]


def somewhere(problem: Problem) -> SearchPoint:
    """A point inside the limits, all of its unknowns away from zero."""
    rng = np.random.default_rng(0)
    low, high = problem.limits
    reach = np.where(np.isfinite(high), high, np.where(np.isfinite(low), low, 0.0) + 1.0)
    sizes = {"N": 60.0, "N s/m": 700.0, "N/m": 500.0, "1/m": 1500.0, "m/s": 0.02, "s": 0.0131, "1/s": 0.3, "kg": 3.0}
    theta = np.concatenate([np.full(c.size, sizes[c.quantity.unit]) for c in problem.columns])
    local = np.column_stack(
        [np.full(len(problem.pieces), {"offset": 90.0}.get(name, 0.1)) for name in problem.common]
        + [np.full(len(problem.pieces), 0.3)] * len(problem.states)
    )
    return SearchPoint(np.minimum(theta * rng.uniform(0.8, 1.2, theta.size), reach + np.abs(theta)), local)


def numeric(problem: Problem, point: SearchPoint, r: int) -> np.ndarray:
    """[nuisances, coefficients, residual] of one record by central differences of the modelled force."""
    one, columns = problem.pieces[r], []
    for j in range(problem.locals):
        up, down = point.local.copy(), point.local.copy()
        up[r, j] += 1e-5
        down[r, j] -= 1e-5
        change = modelled_force(problem, replace(point, local=up), r) - modelled_force(
            problem, replace(point, local=down), r
        )
        columns.append(change / 2e-5)
    for k, value in enumerate(point.theta):
        h = 1e-6 * max(abs(value), 1e-3)
        up, down = point.theta.copy(), point.theta.copy()
        up[k] += h
        down[k] -= h
        change = modelled_force(problem, replace(point, theta=up), r) - modelled_force(
            problem, replace(point, theta=down), r
        )
        columns.append(change / (2 * h))
    columns.append(one.force - modelled_force(problem, point, r))
    return one.weight[:, None] * np.column_stack(columns)


CASES = {
    "plain": ("dahl", {}, False),
    "delayed": ("dahl + hyperbolic_tangent + delay", {}, False),
    "gains and temperatures": ("dahl + spring", {"nuisances": ("offset", "gain", "temperature", "state")}, False),
    "tied": ("dahl + hyperbolic_tangent", {"tied": {"hyperbolic_tangent.ft": "dahl.kw"}}, False),
    "fixed": ("dahl + spring", {"fixed": {"dahl.kx": 500.0}, "nuisances": ("offset", "temperature")}, False),
    "accelerated": ("dahl + inertia", {"fixed": {"inertia.m": 3.0}}, False),
    "varying": ("dahl + spring", {"laws": "polynomial:1"}, True),
    "varying and delayed": ("dahl + delay", {"laws": {"dahl.kx": "constant"}}, True),
    "varying and warm": ("dahl + inertia", {"nuisances": ("offset", "gain", "temperature", "state")}, True),
}


LONG = {
    "delayed",
    "accelerated",
    "gains and temperatures",
    "varying and delayed",
    "varying and warm",
}  # their kernels take long to compile


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.prove if case in LONG else ()) for case in CASES]
)
def test_the_sums_are_those_of_the_derivatives(case: str) -> None:
    model, options, varying = CASES[case]
    listed = [varied(r) for r in records()] if varying else records()
    problem = prepared(model, listed, FitOptions(**options))
    point = somewhere(problem)
    weights = [np.random.default_rng(r).uniform(0.5, 1.5, p.t.size) / p.spread for r, p in enumerate(problem.pieces)]
    weighted = replace(problem, pieces=[replace(p, weight=w) for p, w in zip(problem.pieces, weights, strict=True)])
    for each in (problem, weighted):
        for r, sums in enumerate(products(each, point, by_cluster=True)):
            table = numeric(each, point, r)
            groups = [part.T @ part for part in np.split(table, each.pieces[r].ends[:-1])]
            size = np.sqrt(np.outer(*[np.diag(sum(groups))] * 2)) + 1e-12
            assert len(sums) == len(groups)
            for ours, theirs in zip(sums, groups, strict=True):
                assert np.max(np.abs(ours - theirs) / size) < 2e-5


def varied(record: Record) -> Record:
    return record.replace(note="a swinging voltage", voltage=1.0 + np.sin(1.3 * record.time))


def test_elimination_leaves_the_steps_of_the_joint_problem() -> None:
    problem = prepared("dahl", records())
    point = somewhere(problem)
    here = linearise(problem, point)
    M, L, G = len(problem.pieces), problem.locals, problem.size
    table = np.zeros((0, G + M * L + 1))
    for r in range(M):
        dense = numeric(problem, point, r)
        assert dense.shape[0] == problem.pieces[r].t.size
        row = np.zeros((dense.shape[0], table.shape[1]))
        row[:, :G] = dense[:, L:-1] * np.where(problem.is_logarithmic, point.theta, 1.0)
        row[:, G + r * L : G + (r + 1) * L] = dense[:, :L]
        row[:, -1] = dense[:, -1]
        table = np.vstack((table, row))
    joint = np.linalg.lstsq(table[:, :-1], table[:, -1], rcond=None)[0]
    left = eliminated(here.sums, np.ones((M, L), dtype=bool), np.zeros((M, L)))
    theta = np.linalg.solve(left.matrix, left.target)
    np.testing.assert_allclose(theta, joint[:G], rtol=1e-5)
    np.testing.assert_allclose(left.nuisances(theta).ravel(), joint[G:], rtol=1e-4, atol=1e-6)


def test_records_at_inputs_of_their_own_are_searched_apart_to_the_same_end() -> None:
    problem = prepared("dahl", records())
    assert [len(block.records) for block in independent_blocks(problem)] == [3, 3]
    start = begin(problem)
    one, together = search(problem, start), levenberg_marquardt(problem, start, None, 1e-12)
    np.testing.assert_allclose(one.point.theta, together.point.theta, rtol=1e-4)
    bound = prepared("dahl", records(), FitOptions(laws={"dahl.rho": "constant"}))
    assert len(independent_blocks(bound)) == 1


def test_a_law_that_all_inputs_share_is_not_searched_apart() -> None:
    fit_result = fit(records(0.0), "dahl", laws={"dahl.rho": "polynomial:1"})
    assert fit_result.outcome.cost < 1e-10


@pytest.mark.parametrize("model", ["dahl", "dahl + spring + hyperbolic_tangent"])
@pytest.mark.prove
def test_the_search_ends_where_scipy_ends(model: str) -> None:
    record = records(3.0)[4]
    fixed = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0} if "tangent" in model else {}
    problem = prepared(model, [record], FitOptions(fixed=fixed))
    ours = search(problem, begin(problem), tolerance=1e-12)
    scale = np.concatenate((np.maximum(np.abs(ours.point.theta), 1.0), [100.0, 1.0]))

    def residual(z: np.ndarray) -> np.ndarray:
        at = SearchPoint((z * scale)[:-2], (z * scale)[None, -2:])
        return problem.pieces[0].weight * (problem.pieces[0].force - modelled_force(problem, at, 0))

    end = np.concatenate((ours.point.theta, ours.point.local[0])) / scale
    low, high = (
        np.concatenate((side, edge)) / scale for side, edge in zip(problem.limits, ([-1e6, -1], [1e6, 1]), strict=True)
    )
    start = np.clip(end * 1.02, low + 1e-9, high - 1e-9)
    theirs = least_squares(residual, start, bounds=(low, high), xtol=1e-12, ftol=1e-14, gtol=1e-14)
    assert ours.cost <= theirs.cost * (1 + 1e-7)


def test_two_parts_that_say_nearly_the_same_do_not_stop_the_search() -> None:
    damper = Damper("dahl + spring", {"dahl.kx": 800.0, "dahl.kw": 60.0, "dahl.rho": 40.0, "spring.k0": 100.0})
    record = sine(damper, 0.0, amplitude=0.004, noise=0.2)
    fit_result = fit(record, "dahl + spring")
    problem = fit_result.problem
    again = search(
        problem, replace(fit_result.outcome.point, theta=fit_result.outcome.point.theta * 1.3), tolerance=1e-11
    )
    assert again.cost == pytest.approx(fit_result.outcome.cost, rel=1e-6)


def test_gain_and_what_is_left_are_those_of_the_quadratic() -> None:
    rng = np.random.default_rng(1)
    tables = [rng.normal(size=(30, 6)) for _ in range(3)]  # two nuisances, three coefficients, the residual
    sums = np.stack([table.T @ table for table in tables])
    nothing = np.zeros(3, dtype=bool)
    here = NormalEquations(sums, nothing, nothing[:2], *np.zeros((2, 3)), np.zeros((3, 2)), np.zeros((3, 2)))
    step = SearchStep(rng.normal(size=3), rng.normal(size=(3, 2)))
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
    moved_on = step_point(problem, point, SearchStep(np.array([3.0, -4.0, 0.5]), np.zeros((1, 2))))
    np.testing.assert_allclose(moved_on.theta, point.theta * [1, 1, np.exp(0.5)] + [3.0, 0.0, 0.0], atol=1e-8)
    assert moved_on.theta[1] >= 0.0
