"""Groups of an ensemble's cases: one peak a case, at the intensity of its motion."""

from __future__ import annotations

import numpy as np
import pytest
from tests.structures.ensembles.known_peaks import drawn, made

from dampyr.errors import InputError
from dampyr.structures import fragility, incremental


def test_motions_scaled_to_one_peak_have_one_intensity_whatever_the_rounding() -> None:
    """A peak of 3.0000000000000004 and one of 3 are those of motions scaled to 3 m/s2: the same curve and band as of 3."""
    capacity, exact = drawn(20), np.full(20, 3.0)
    rounded = exact * (1.0 + np.finfo(float).eps * np.random.default_rng(4).integers(-2, 3, 20))
    coarse = np.linspace(0.3, 4.5, 8)
    a, b = (made(capacity, coarse, pga=pga) for pga in (exact, rounded))
    for one, other in zip(*(fragility(data, "drift", 1.0, draws=100).curves for data in (a, b))):
        assert one.levels.size == other.levels.size == 8
        assert one.theta == pytest.approx(other.theta, rel=1e-12)
        assert one.no_band == other.no_band
        np.testing.assert_allclose(one.draws, other.draws, rtol=1e-9)
    assert [incremental(each, "drift").sweeps[0].levels.size for each in (a, b)] == [8, 8]


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
