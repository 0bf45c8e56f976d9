"""Mean and spread of groups from estimates with errors: closed forms, quantiles, and how often intervals hold."""

import numpy as np
import pytest
from scipy.stats import chi2, t

from dampyr.identification.parameter_uncertainty.random_effects import random_effects


def test_of_equal_errors_everything_has_a_closed_form() -> None:
    y, s, k = np.array([1.0, 1.4, 0.7, 1.9, 1.2, 0.8]), 0.15, 6
    one = random_effects(y, np.full(k, s))
    variance = float(np.var(y, ddof=1))
    assert one.mean == pytest.approx(y.mean())
    assert one.spread == pytest.approx(np.sqrt(variance - s**2), rel=1e-5)
    assert one.mean_error == pytest.approx(np.sqrt(variance / k), rel=1e-5)
    reach = t.ppf(0.975, k - 1) * np.sqrt(variance / k)
    np.testing.assert_allclose(one.mean_interval, (y.mean() - reach, y.mean() + reach), rtol=1e-5)
    ends = np.sqrt((k - 1) * variance / chi2.ppf([0.975, 0.025], k - 1) - s**2)
    np.testing.assert_allclose(one.spread_interval, ends, rtol=1e-6)
    share = one.spread**2 / (one.spread**2 + s**2)
    np.testing.assert_allclose(one.shrunken, y.mean() + share * (y - y.mean()))


def test_a_new_group_without_errors_is_within_students_t() -> None:
    y = np.array([1.0, 1.4, 0.7, 1.9, 1.2])
    reach = t.ppf([0.025, 0.975], 4) * np.std(y, ddof=1) * np.sqrt(1 + 1 / 5)
    np.testing.assert_allclose(random_effects(y, np.full(5, 1e-6)).prediction, y.mean() + reach, atol=1e-4)


@pytest.mark.parametrize("s", [0.15, 0.4, 3.0])
def test_a_new_group_of_equal_errors_is_within_the_quantiles_of_draws(s: float) -> None:
    """Chi-squared over the sum of squares is the inverse of the whole variance, of which the errors' part is known."""
    y, rng = np.array([1.0, 1.4, 0.7, 1.9, 1.2, 0.8]), np.random.default_rng(3)
    variance = np.maximum(np.sum((y - y.mean()) ** 2) / rng.chisquare(5, 400_000) - s**2, 0.0)
    drawn = y.mean() + np.sqrt(variance + (variance + s**2) / 6) * rng.standard_normal(variance.size)
    low, high = random_effects(y, np.full(6, s), 0.9).prediction
    np.testing.assert_allclose((low, high), np.quantile(drawn, [0.05, 0.95]), atol=0.01 * (high - low))


def test_the_mean_is_never_told_better_than_the_errors_allow() -> None:
    """Hartung and Knapp's own interval of estimates that agree by chance would be a tenth of this one."""
    y, s = np.array([1.0, 1.01, 0.99, 1.005]), np.array([0.1, 0.12, 0.09, 0.1])
    one = random_effects(y, s)
    assert one.spread == 0.0
    assert one.mean_error == pytest.approx(np.sum(s**-2.0) ** -0.5)
    low, high = one.mean_interval
    assert high - low == pytest.approx(2 * t.ppf(0.975, 3) * one.mean_error)


@pytest.mark.prove
@pytest.mark.parametrize(
    ("k", "spread"),
    [
        pytest.param(k, spread, marks=[] if (k, spread) in ((3, 5.0), (5, 0.4), (12, 1.0)) else pytest.mark.by_hand)
        for k in (3, 4, 5, 8, 12)
        for spread in (0.4, 1.0, 5.0)
    ],
)
def test_intervals_hold_a_new_group_as_often_as_they_say(k: int, spread: float) -> None:
    """Errors of 1: with the most likely spread alone, the interval of a new one held 84 to 92 %."""
    repeats = 400
    rng = np.random.default_rng([int(10 * spread), k])
    new, mean = 0, 0
    for _ in range(repeats):
        one = random_effects(spread * rng.standard_normal(k) + rng.standard_normal(k), np.ones(k))
        new += one.prediction[0] <= spread * rng.standard_normal() <= one.prediction[1]
        mean += one.mean_interval[0] <= 0.0 <= one.mean_interval[1]
    assert (
        new / repeats >= 0.91
    )  # 0.95 less its standard error of 0.011 of 400, and as much again for what is not exact
    assert mean / repeats >= 0.92
    if spread >= 1.0:
        assert new / repeats <= 0.99


def test_of_unequal_errors_q_is_at_its_quantiles_and_the_likelihood_at_its_top() -> None:
    rng = np.random.default_rng(1)
    s = rng.uniform(0.05, 0.4, 9)
    y = 2.0 + 0.8 * rng.standard_normal(9) + s * rng.standard_normal(9)
    one = random_effects(y, s)
    for end, share in zip(one.spread_interval, (0.975, 0.025), strict=True):
        w = 1.0 / (end**2 + s**2)
        assert w @ (y - w @ y / w.sum()) ** 2 == pytest.approx(chi2.ppf(share, 8))

    def likelihood(spread: float) -> float:
        w = 1.0 / (spread**2 + s**2)
        return float(0.5 * (np.log(w).sum() - np.log(w.sum()) - w @ (y - w @ y / w.sum()) ** 2))

    assert all(likelihood(one.spread) >= likelihood(other) for other in np.linspace(0.0, 2.0, 500))


@pytest.mark.parametrize("repeats", [80, pytest.param(200, marks=pytest.mark.prove)])
def test_without_spread_its_lower_end_is_zero(repeats: int) -> None:
    rng, s = np.random.default_rng(2), np.full(10, 0.05)
    ends = [random_effects(s * rng.standard_normal(10), s).spread_interval for _ in range(repeats)]
    share = np.mean([low == 0.0 for low, _ in ends])
    assert share > 0.94  # 97.5 % of them are expected
    assert np.mean([high >= 0.0 for _, high in ends]) == 1.0
