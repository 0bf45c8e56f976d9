"""Bounded least squares against numpy and scipy."""

import numpy as np
from scipy.optimize import lsq_linear

from dampyr.identification.search.bounded_least_squares import solve_bounded, solve_by_cholesky, solve_by_eigenvalues
from dampyr.models.codegen.kernels import compile_cached

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


def test_a_step_inside_the_limits_is_that_of_scipy() -> None:
    for seed in range(40):
        rng = np.random.default_rng(seed)
        A, b = rng.normal(size=(30, 7)) @ np.diag(10.0 ** rng.uniform(-2, 2, 7)), rng.normal(size=30)
        low, high = -rng.uniform(0, 0.3, 7), rng.uniform(0, 0.3, 7)
        low[rng.random(7) < 0.2], high[rng.random(7) < 0.2] = -np.inf, 0.0
        theirs = lsq_linear(A, b, (low, np.maximum(high, low + 1e-9)), method="bvls", tol=1e-14).x
        ours = solve_bounded(np.column_stack((A.T @ A, A.T @ b)), 0.0, low, high, np.ones(7, dtype=bool))
        assert np.all((ours >= low) & (ours <= high))
        assert np.linalg.norm(A @ ours - b) <= np.linalg.norm(A @ theirs - b) * (1 + 1e-9)


def test_a_near_singular_step_inside_the_limits_is_optimal_too() -> None:
    for seed in range(20):
        S, rng = normal_equations(seed, twins=1e-8), np.random.default_rng(seed)
        H, g = S[:, :6], S[:, 6]
        whole = solve_by_eigenvalues(H, g)
        low, high = -rng.uniform(0.1, 0.8, 6) * np.abs(whole), rng.uniform(0.1, 0.8, 6) * np.abs(whole)
        step = solve_bounded(S, 0.0, low, high, FREE)
        assert np.all((step >= low) & (step <= high))
        slope = (g - H @ step) / np.sqrt(np.diag(H))  # uphill of what is minimised, per unknown of size one
        small = 1e-6 * np.max(np.abs(g) / np.sqrt(np.diag(H)))
        assert np.all(slope[step == low] < small)
        assert np.all(slope[step == high] > -small)
        assert np.all(np.abs(slope[(step > low) & (step < high)]) < small)
        assert np.any((step == low) | (step == high))
