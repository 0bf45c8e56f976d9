"""The bleed that shuts: its limits, its signs, and what a fit finds."""

from itertools import pairwise

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper

NUMBERS = {"c": 1700.0, "fy": 185.0, "vy": 5e-4, "b": 46e3, "d": 1.6e-4}


def damper(**changes: float) -> Damper:
    return Damper("shutting_bleed", {f"shutting_bleed.{key}": value for key, value in (NUMBERS | changes).items()})


def force(x: np.ndarray, v: np.ndarray, **changes: float) -> np.ndarray:
    return damper(**changes).force(np.arange(len(x)) * 1.0, x, voltage=0.0, velocity=v)


def gap(v: float, **changes: float) -> float:
    n = NUMBERS | changes
    return float(n["fy"] * np.tanh(abs(v) / n["vy"]) + n["c"] * abs(v))


def test_it_is_open_after_a_reversal_and_shut_after_a_path_of_twice_d() -> None:
    v, d = 0.01, NUMBERS["d"]
    x = np.array([0.0, 2 * d, 4 * d, 4 * d, 4 * d - 2 * d])
    got = force(x, np.array([v, v, v, -v, -v]))
    open_ = gap(v) * NUMBERS["b"] * v / np.hypot(gap(v), NUMBERS["b"] * v)
    assert got[1:3] == pytest.approx([gap(v), gap(v)])  # shut
    assert got[3] == pytest.approx(-open_)  # the direction has changed and no path is behind it
    assert got[4] == pytest.approx(-gap(v))


def test_without_a_path_or_with_a_wide_bleed_it_is_the_hyperbolic_tangent() -> None:
    t = np.linspace(0.0, 2.0, 4001)
    x, v = 0.01 * np.sin(6 * t), 0.06 * np.cos(6 * t)
    plain = {"c": NUMBERS["c"], "ft": NUMBERS["fy"], "v0": 5e-3, "s": 0.0}
    tanh = Damper("hyperbolic_tangent", {f"hyperbolic_tangent.{key}": value for key, value in plain.items()})
    expected = tanh.force(t, x, voltage=0.0, velocity=v)
    for narrow in ({"d": 1e-9}, {"b": 1e12}):
        away = (np.abs(v) > 1e-3) & (t > 0.0)  # at the first sample no path is behind it
        got = damper(vy=5e-3, **narrow).force(t, x, voltage=0.0, velocity=v)
        np.testing.assert_allclose(got[away], expected[away], rtol=1e-6)


def test_it_only_dissipates_and_rises_with_the_speed_and_the_path() -> None:
    rng = np.random.default_rng(0)
    v = 0.02 * rng.standard_normal(20_000)
    x = np.cumsum(1e-2 * v)
    assert np.min(force(x, v) * v) >= 0.0
    for speeds in pairwise(np.geomspace(1e-6, 0.3, 40)):
        slow, fast = (force(np.array([0.0, 1e-4]), np.array([s, s]))[1] for s in speeds)
        assert fast > slow
    assert force(np.array([0.0, 1e-4]), np.zeros(2))[1] == 0.0
    forces = force(np.linspace(0.0, 4e-4, 30), np.full(30, 0.01))
    assert np.all(np.diff(forces) >= 0.0)


def test_its_three_forces_scale_together() -> None:
    x, v = np.array([0.0, 1e-4, 5e-5]), np.array([0.01, 0.02, -0.01])
    twice = force(x, v, c=2 * NUMBERS["c"], fy=2 * NUMBERS["fy"], b=2 * NUMBERS["b"])
    np.testing.assert_allclose(twice, 2.0 * force(x, v), rtol=1e-12)


@pytest.mark.prove
def test_a_fit_gives_the_numbers_back() -> None:
    made = [
        sine(damper(vy=2e-3), 0.0, f"{A:g}", amplitude=A, frequency=f)
        for A, f in ((0.002, 2.0), (0.005, 1.0), (0.01, 2.0))
    ]
    result = fit(made, "shutting_bleed")
    expected = NUMBERS | {"vy": 2e-3}
    assert result.converged, result.reason
    for key, value in expected.items():
        assert result.parameters[f"shutting_bleed.{key}"] == pytest.approx(value, rel=0.01), key
