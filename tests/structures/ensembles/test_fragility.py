"""Fragility curves of made-up peaks whose curve is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.endurance import Endurance
from tests.structures.ensembles.known_peaks import SCALES, drawn, made

from dampyr.errors import InputError
from dampyr.structures import fragility, incremental


def test_a_known_curve_is_found_within_its_band() -> None:
    [curve] = fragility(made(drawn(200)), "drift", 1.0, "scale", draws=200).curves
    assert curve.theta == pytest.approx(1.5, rel=0.08)
    assert curve.beta == pytest.approx(0.4, rel=0.2)
    assert curve.theta_band()[0] < 1.5 < curve.theta_band()[1]
    assert curve.at(curve.theta) == pytest.approx(0.5)
    low, high = curve.band([0.8, 1.5, 3.0])
    assert np.all((low < curve.at([0.8, 1.5, 3.0])) & (curve.at([0.8, 1.5, 3.0]) < high))
    assert curve.of.sum() == 200 * 20


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


def test_motions_are_the_unit_and_draws_belong_to_them() -> None:
    """Ten equal draws of the damper change neither the curve nor, as copies would, the band."""
    names = tuple(f"damper {k}" for k in range(10))
    one, ten = made(drawn(40)), made(drawn(40, draws=10), dampers=names)
    [alone], [pooled] = (fragility(d, "drift", 1.0, "scale", draws=100, seed=7).curves for d in (one, ten))
    assert pooled.of.sum() == 10 * alone.of.sum()
    assert pooled.theta == pytest.approx(alone.theta, rel=1e-9)
    np.testing.assert_allclose(pooled.draws, alone.draws, rtol=1e-6)
    assert len(fragility(ten, "drift", 1.0, "scale", by="damper", draws=0).curves) == 10


def test_seeds() -> None:
    data = made(drawn(20))
    one, same, other = (fragility(data, "drift", 1.0, "scale", draws=50, seed=s).curves[0].draws for s in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert not np.array_equal(one, other)


def test_a_ratio_of_the_height() -> None:
    data = made(drawn(30))
    metres, ratio = (
        fragility(data, limit=1.5, intensity="scale", draws=0),
        fragility(data, limit=0.5, intensity="scale", height=3.0, draws=0),
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


@pytest.mark.prove
@pytest.mark.endure
def test_the_band_covers_the_truth_as_often_as_it_says(endurance: Endurance) -> None:
    """90 % bands of the median from 40 motions: of 300 studies between 83 and 95 %."""
    held, studies = 0, 300 if endurance.full else 15
    for k in range(studies):
        [curve] = fragility(made(drawn(40, seed=100 + k)), "drift", 1.0, "scale", draws=200, seed=k).curves
        low, high = curve.theta_band(0.9)
        held += low < 1.5 < high
    endurance.report(
        "90 % bands of a fragility's median from 40 motions", 100, f"{studies} studies: {100 * held / studies:.1f} %"
    )
    few = 0.0 if endurance.full else 0.15  # two standard errors of 15 studies
    assert 0.83 - few <= held / studies <= 0.95 + few
