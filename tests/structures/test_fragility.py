"""Fragility curves and incremental analyses of made-up peaks whose curve is known, and of independent likelihoods."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import binom, norm
from tests.endurance import Endurance

from dampyr.errors import InputError
from dampyr.structures import fragility, incremental, summary
from dampyr.structures.ensembles.lognormal import by_capacity, fit_binomial
from dampyr.structures.ensembles.store import Labels

SCALES = np.linspace(0.2, 4.0, 20)


def made(capacity: np.ndarray, scales: np.ndarray = SCALES, dampers: tuple[str, ...] = ("damper",), **more: Any) -> Any:
    """An ensemble of one storey whose peak is scale / capacity; ``capacity`` (damper, input, motion)."""
    _, u, m = capacity.shape
    pga = more.get("pga", np.ones(m))
    labels = Labels(
        ["tower"], list(dampers), list(range(u)), [f"motion {k}" for k in range(m)], scales.tolist(), "voltage",
        [0.5], list(pga), [list(pga)],
    )  # fmt: skip
    peaks = scales / capacity[..., None]
    return labels.dataset({"drift": peaks.reshape(-1, len(scales), 1)}, {})


def drawn(motions: int, theta: float = 1.5, beta: float = 0.4, seed: int = 1, draws: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return theta * np.exp(beta * rng.standard_normal((1, 1, motions))) * np.ones((draws, 1, 1))


def test_a_known_curve_is_found_within_its_band() -> None:
    [curve] = fragility(made(drawn(200)), "drift", 1.0, "scale", draws=200).curves
    assert curve.theta == pytest.approx(1.5, rel=0.08)
    assert curve.beta == pytest.approx(0.4, rel=0.2)
    assert curve.theta_band()[0] < 1.5 < curve.theta_band()[1]
    assert curve.at(curve.theta) == pytest.approx(0.5)
    low, high = curve.band([0.8, 1.5, 3.0])
    assert np.all((low < curve.at([0.8, 1.5, 3.0])) & (curve.at([0.8, 1.5, 3.0]) < high))
    assert curve.of.sum() == 200 * 20


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


@pytest.mark.parametrize("draws", [1, 3])
def test_the_spread_of_first_exceedances_is_the_unbiased_one(draws: int) -> None:
    """Baker (2015), equation 3; equal draws of the damper are no more motions."""
    [curve] = fragility(made(drawn(6, draws=draws), dampers=("damper",) * draws), "drift", 1.0, "scale", draws=0).curves
    logs = np.log(drawn(6)[0, 0])
    assert curve.capacities.observed == 6 * draws
    assert curve.direct.theta == pytest.approx(np.exp(logs.mean()), rel=1e-9)
    assert curve.direct.beta == pytest.approx(logs.std(ddof=1), rel=1e-9)


def test_first_exceedances_lie_where_the_peak_crosses() -> None:
    capacity = drawn(30, theta=2.5, beta=0.7)
    [curve] = fragility(made(capacity), "drift", 1.0, "scale", draws=0).curves
    inside = (capacity[0, 0] > SCALES[0]) & (capacity[0, 0] < SCALES[-1])
    np.testing.assert_allclose(curve.capacities.value[0][inside], capacity[0, 0][inside], rtol=1e-12)
    assert curve.capacities.above == (capacity > SCALES[-1]).sum() > 0
    assert curve.no_band == "no bootstrap was asked for"
    assert np.isnan(curve.band([1.0])).all()


def test_a_curve_that_bends_back_counts_its_first_crossing() -> None:
    data = made(drawn(3))
    data.drift[..., 0, :, 0] = [0.1, 0.5, 1.5, 0.5, 0.2, *np.linspace(0.3, 4.0, 15)]
    [curve] = fragility(data, "drift", 1.0, "scale", draws=0).curves
    assert curve.capacities.value[0, 0] == pytest.approx(SCALES[1] + 0.5 * (SCALES[2] - SCALES[1]))
    [sweep] = incremental(data, intensity="scale").sweeps
    assert sweep.bent_back == 1
    np.testing.assert_array_equal(sweep.peaks[0], data.drift.values[0, 0, 0, 0, :, 0])


def test_cases_without_bound_exceed_and_are_counted() -> None:
    data = made(drawn(20))
    lost = data.drift.values[0, 0, 0, :, :, 0] > 1.2
    data.drift.values[0, 0, 0, lost, 0] = np.nan
    [curve], [whole] = (fragility(d, "drift", 1.0, "scale", draws=0).curves for d in (data, made(drawn(20))))
    assert curve.unbounded == lost.sum() > 0
    assert (curve.theta, curve.beta) == (whole.theta, whole.beta)
    assert curve.direct.theta == pytest.approx(whole.direct.theta, rel=0.05)
    [sweep] = incremental(data, intensity="scale").sweeps
    assert np.isinf(sweep.fractiles[2, -1])
    assert sweep.unbounded == lost.sum()


@pytest.mark.parametrize(
    ("limit", "motions", "message"),
    [
        (100.0, 9, "no case exceeds"),
        (1e-3, 9, "every case exceeds"),
        (1.0, 1, "the spread cannot be told"),
    ],
)
def test_no_curve_is_a_value_with_a_reason(limit: float, motions: int, message: str) -> None:
    [curve] = fragility(made(drawn(motions)), "drift", limit, "scale", draws=20).curves
    assert message in curve.reason
    assert not curve.exists
    assert np.isnan([curve.theta, curve.beta, *curve.band(1.0), *curve.theta_band(), curve.at(1.0)]).all()
    assert curve.no_band == curve.reason


def test_a_fragility_that_falls_is_none() -> None:
    x = np.array([1.0, 2.0, 3.0])
    assert "this is not a fragility" in fit_binomial(x, np.array([8.0, 5.0, 2.0]), np.full(3, 10.0)).reason
    assert "this is not a fragility" in fit_binomial(x, np.array([9.0, 0.0, 0.0]), np.full(3, 9.0)).reason


def test_motions_are_the_unit_and_draws_belong_to_them() -> None:
    """Ten equal draws of the damper change neither the curve nor, as copies would, the band."""
    names = tuple(f"damper {k}" for k in range(10))
    one, ten = made(drawn(40)), made(drawn(40, draws=10), dampers=names)
    [alone], [pooled] = (fragility(d, "drift", 1.0, "scale", draws=100, seed=7).curves for d in (one, ten))
    assert pooled.of.sum() == 10 * alone.of.sum()
    assert pooled.theta == pytest.approx(alone.theta, rel=1e-9)
    np.testing.assert_allclose(pooled.draws, alone.draws, rtol=1e-6)
    assert len(fragility(ten, "drift", 1.0, "scale", by="damper", draws=0).curves) == 10


def test_motions_scaled_to_one_peak_have_one_intensity_whatever_the_rounding() -> None:
    """A peak of 3.0000000000000004 and one of 3 are those of motions scaled to 3 m/s2: the same curve and band as of 3."""
    capacity, exact = drawn(20), np.full(20, 3.0)
    rounded = exact * (1.0 + np.finfo(float).eps * np.random.default_rng(4).integers(-2, 3, 20))
    coarse = np.linspace(0.3, 4.5, 8)
    a, b = (made(capacity, coarse, pga=pga) for pga in (exact, rounded))
    for one, other in zip(fragility(a, "drift", 1.0).curves, fragility(b, "drift", 1.0).curves):
        assert one.levels.size == other.levels.size == 8
        assert one.theta == pytest.approx(other.theta, rel=1e-12)
        assert one.no_band == other.no_band
        np.testing.assert_allclose(one.draws, other.draws, rtol=1e-9)
    assert [incremental(each, "drift").sweeps[0].levels.size for each in (a, b)] == [8, 8]


def test_seeds() -> None:
    data = made(drawn(20))
    one, same, other = (fragility(data, "drift", 1.0, "scale", draws=50, seed=s).curves[0].draws for s in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)


def test_a_bare_building_is_never_pooled_and_curves_compare_in_pairs() -> None:
    base = drawn(60, beta=0.5)
    capacity = np.concatenate([np.repeat(base, 2, axis=1), np.concatenate([1.3 * base, 1.6 * base], axis=1)])
    result = fragility(
        made(capacity, np.linspace(0.1, 8, 60), ("no damper", "damper")), "drift", 1.0, "scale", draws=200
    )
    assert [curve.name for curve in result.curves] == ["no damper", "0 V", "1 V"]
    ratio, low, high = result.ratio("1 V", "no damper")
    assert low <= ratio <= high
    assert ratio == pytest.approx(1.6, rel=0.02)
    assert high - low < 0.1  # as pairs; each median alone is known to about 20 %
    assert result.to_xarray().sel(curve="0 V").theta == result["0 V"].theta
    with pytest.raises(InputError, match="there is no curve '2 V'; choose from no damper, 0 V, 1 V"):
        result["2 V"]


def test_the_intensity_is_that_of_the_scaled_motion() -> None:
    pga = np.linspace(1.0, 3.0, 50)
    capacity = drawn(50) / pga  # in PGA the capacities are those drawn
    [curve] = fragility(made(capacity, np.linspace(0.02, 6, 200), pga=pga), "drift", 1.0, "pga", draws=0).curves
    [own] = fragility(made(capacity, np.linspace(0.02, 6, 200)), "drift", 1.0, pga, draws=0).curves
    assert curve.direct.theta == pytest.approx(np.exp(np.log(drawn(50)).mean()), rel=1e-9)
    assert (own.theta, own.beta) == (curve.theta, curve.beta)
    assert len(curve.shares()[0]) == 24
    assert curve.shares()[2].sum() == 50 * 200


def test_fractiles_are_those_across_motions_at_one_intensity() -> None:
    capacity = drawn(41)
    curves = incremental(made(capacity), intensity="scale", fractions=(0.16, 0.5))
    np.testing.assert_allclose(
        curves["0 V"].fractiles, np.quantile(SCALES / capacity[0, 0][:, None], (0.16, 0.5), axis=0), rtol=1e-12
    )
    pga = np.linspace(1.0, 3.0, 41)
    sweep = incremental(made(capacity, pga=pga), intensity="pga", fractions=(0.5,)).sweeps[0]
    assert (sweep.levels[0], sweep.levels[-1]) == pytest.approx((3 * SCALES[0], SCALES[-1]))
    slopes = 1.0 / (capacity[0, 0] * pga)
    np.testing.assert_allclose(sweep.fractiles[0], np.median(slopes) * sweep.levels, rtol=1e-12)


def test_a_ratio_of_the_height() -> None:
    data = made(drawn(30))
    metres, ratio = (
        fragility(data, limit=1.5, intensity="scale"),
        fragility(data, limit=0.5, intensity="scale", height=3.0),
    )
    assert metres.curves[0].theta == ratio.curves[0].theta
    assert (metres.limit_unit, ratio.limit_unit) == ("m", "")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"quantity": "force"}, "is not in this ensemble; it has drift"),
        ({"limit": -1.0}, "limit = -1.0 is not allowed"),
        ({"intensity": "sd"}, "choose from pga, sa, scale"),
        ({"intensity": [1.0]}, "one number for each of the 5 motions"),
        ({"storey": 2}, "write 'worst' or count from 1 to 1"),
        ({"by": "scale"}, "choose from building, damper, input"),
        ({"height": 0.0}, "above 0"),
        ({"draws": -1}, "0 \\(no bands\\) or more"),
    ],
)
def test_what_is_wrong_is_said(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        fragility(made(drawn(5)), **given)


def test_a_summary_has_medians_and_84_per_cent() -> None:
    capacity = drawn(50)
    [row] = summary(made(capacity))
    assert row.scale == 1.0
    np.testing.assert_allclose(row.peaks["drift"], np.quantile(1.0 / capacity, [0.5, 0.84]))


@pytest.mark.prove
@pytest.mark.endure
def test_the_band_covers_the_truth_as_often_as_it_says(endurance: Endurance) -> None:
    """90 % bands of the median from 40 motions: of 300 studies between 83 and 95 %."""
    held, studies = 0, 300 if endurance.full else 60
    for k in range(studies):
        [curve] = fragility(made(drawn(40, seed=100 + k)), "drift", 1.0, "scale", draws=200, seed=k).curves
        low, high = curve.theta_band(0.9)
        held += low < 1.5 < high
    endurance.report(
        "90 % bands of a fragility's median from 40 motions", 100, f"{studies} studies: {100 * held / studies:.1f} %"
    )
    few = 0.0 if endurance.full else 0.05  # 60 studies have a standard error of 4 %
    assert 0.83 - few <= held / studies <= 0.95 + few
