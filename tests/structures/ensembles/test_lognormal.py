"""Lognormal curves by likelihoods written out here."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import binom, norm

from dampyr.structures.ensembles.lognormal import by_capacity, fit_binomial


def test_the_likelihood_is_that_of_the_binomial() -> None:
    rng = np.random.default_rng(3)
    x, n = np.geomspace(0.3, 4.0, 9), np.full(9, 30.0)
    k = rng.binomial(30, norm.cdf(np.log(x / 1.2) / 0.5)).astype(float)

    def cost(p: np.ndarray) -> float:
        return -float(binom.logpmf(k, 30, norm.cdf(np.log(x / np.exp(p[0])) / np.exp(p[1]))).sum())

    best = minimize(cost, [0.0, 0.0], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000})
    curve = fit_binomial(x, k, n)
    assert [curve.theta, curve.beta] == pytest.approx(np.exp(best.x), rel=1e-5)


def test_the_likelihood_of_censored_capacities() -> None:
    rng = np.random.default_rng(4)
    capacity = 1.5 * np.exp(0.5 * rng.standard_normal(60))
    kind = np.where(capacity > 2.0, 1, np.where(capacity < 0.7, -1, 0))
    x = np.clip(capacity, 0.7, 2.0)
    assert (kind > 0).sum() > 5
    assert (kind < 0).sum() > 3

    def cost(p: np.ndarray) -> float:
        z = (np.log(x) - p[0]) / np.exp(p[1])
        terms = np.select([kind == 0, kind > 0], [norm.logpdf(z) - p[1], norm.logsf(z)], norm.logcdf(z))
        return -float(terms.sum())

    best = minimize(cost, [0.0, 0.0], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000})
    curve = by_capacity(x, kind, np.ones(60))
    assert [curve.theta, curve.beta] == pytest.approx(np.exp(best.x), rel=1e-5)


def test_uncensored_capacities_have_the_moments_of_their_logarithms() -> None:
    capacity = np.random.default_rng(5).lognormal(0.3, 0.6, 50)
    curve = by_capacity(capacity, np.zeros(50), np.ones(50))
    assert curve.theta == pytest.approx(np.exp(np.log(capacity).mean()), rel=1e-9)
    assert curve.beta == pytest.approx(np.log(capacity).std(), rel=1e-9)


def test_a_fragility_that_falls_is_none() -> None:
    x = np.array([1.0, 2.0, 3.0])
    assert "this is not a fragility" in fit_binomial(x, np.array([8.0, 5.0, 2.0]), np.full(3, 10.0)).reason
    assert "this is not a fragility" in fit_binomial(x, np.array([9.0, 0.0, 0.0]), np.full(3, 9.0)).reason
