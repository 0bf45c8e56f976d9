# Ikhouane and Rodellar (2007), Systems with Hysteresis: the classes of the model; Raminelli (2020), (2.2), solved by scipy.
"""The Bouc-Wen model that may harden: its equation, its limits in stroke, its energy, its letters, and what a fit finds."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from tests.models.parts.found_again import assert_found_again, damper

from dampyr.errors import InputError
from dampyr.identification.model_choice.leaderboard import _is_tried
from dampyr.models.numerics.bouc_wen_two_sided import (
    two_sided_by_back,
    two_sided_by_n,
    two_sided_by_out,
    two_sided_by_xi,
    two_sided_by_y,
    two_sided_flow,
)
from dampyr.models.part import part
from dampyr.models.parts.hardening_bouc_wen import HardeningBoucWen, from_printed, longest_way, to_printed

NAME = "hardening_bouc_wen"
NUMBERS = {"c0": 700.0, "k0": 900.0, "kw": 150.0, "rho": 60.0, "h": 0.5, "n": 1.6}
PLAIN = NUMBERS | {"c0": 0.0, "k0": 0.0}


def along(x: np.ndarray, name: str = NAME, **changes: float) -> np.ndarray:
    numbers = PLAIN | changes if name == NAME else changes
    return damper(name, numbers).force(np.arange(x.size) * 1.0, x, voltage=0.0, velocity=np.zeros(x.size))


@pytest.mark.usefixtures("plain")
def test_the_printed_equation_is_met_at_any_step() -> None:
    """(2.2) with its own letters, as printed, along x = 6 mm sin s sampled every half radian; reversals between samples."""
    there = to_printed(HardeningBoucWen(**PLAIN), A=0.7)
    s = np.concatenate([np.arange(0.0, 12.0, 0.5), np.pi * (np.arange(4) + 0.5)])
    s.sort()

    def rate(at: float, y: np.ndarray) -> list[float]:
        v, z = 0.006 * np.cos(at), y[0]
        return [
            -there.gamma * z * abs(v) * abs(z) ** (there.n - 1.0) - there.beta * v * abs(z) ** there.n + there.A * v
        ]

    z = solve_ivp(rate, (0.0, s[-1]), [0.0], "LSODA", t_eval=s, rtol=1e-10, atol=1e-13, max_step=0.01).y[0]
    np.testing.assert_allclose(along(0.006 * np.sin(s)), there.alpha * z, atol=2e-7 * there.alpha * np.abs(z).max())


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize("h", [-1.0, -0.4, -1e-3])
def test_without_hardening_it_is_bouc_wen(h: float) -> None:
    x = np.append(0.0, 0.02 * np.random.default_rng(0).standard_normal(60))
    m = (-h) ** (1 / 1.6)
    usual = {"c0": 0.0, "k0": 0.0, "kw": 150.0 / m, "rho": 60.0 * m, "sigma": -1.0 / h, "n": 1.6}
    np.testing.assert_allclose(along(x, h=h), along(x, "bouc_wen", **usual), rtol=1e-8, atol=1e-8)


@pytest.mark.usefixtures("plain")
def test_it_is_refused_at_the_end_of_the_longest_way_and_not_before() -> None:
    end = longest_way(HardeningBoucWen(**PLAIN))
    assert end == pytest.approx(quad(lambda u: 1.0 / (1.0 + 0.5 * u**1.6), 0.0, np.inf)[0] / 60.0, rel=1e-6)
    assert longest_way(HardeningBoucWen(**(PLAIN | {"n": 2.0}))) == pytest.approx(math.pi / 2 / math.sqrt(0.5) / 60.0)
    assert longest_way(HardeningBoucWen(**(PLAIN | {"n": 1.0}))) == math.inf
    assert longest_way(HardeningBoucWen(**(PLAIN | {"h": 0.0}))) == math.inf
    assert np.isfinite(along(np.array([0.0, 0.9 * end, 0.999 * end, 0.0]))).all()
    # as plain Python its numbers are numpy's, which warn of the infinity
    with (
        np.errstate(over="ignore"),
        pytest.raises(InputError, match=r"at 2 s: .*longest_way"),
    ):
        along(np.array([0.0, 0.9 * end, 1.001 * end, 0.0]))


@pytest.mark.usefixtures("plain")
def test_a_stroke_bounds_the_state_whatever_the_path_within_it() -> None:
    """The claim of the page, on paths that turn anywhere."""
    width = 0.03
    largest = along(np.array([0.0, width]))[-1]
    for seed in range(3):
        x = np.append(0.0, np.random.default_rng(seed).uniform(0.0, width, 400))
        assert np.abs(along(x)).max() <= largest * (1.0 + 1e-9)
    cycles = along(np.append(0.0, 0.5 * width * np.tile([1.0, -1.0], 20)))
    assert np.abs(cycles[-1]) == pytest.approx(np.abs(cycles[-2]), rel=1e-9)  # it closes, and does not grow


@pytest.mark.usefixtures("plain")
def test_what_is_not_stored_is_only_dissipated() -> None:
    nodes = np.append(0.0, 0.006 * np.random.default_rng(1).standard_normal(30))
    x = np.interp(np.linspace(0.0, 30.0, 3001), np.arange(31.0), nodes)
    w = along(x) / 150.0
    work = np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(x))
    grid = np.linspace(0.0, np.abs(w).max(), 4001)
    stored = np.append(
        0.0, np.cumsum(np.diff(grid) * (f := grid / (1.0 + 2.5 * grid**1.6))[1:] - 0.5 * np.diff(f) * grid[1])
    )
    lost = work - np.interp(np.abs(w[1:]), grid, stored) / 60.0
    assert np.min(np.diff(lost)) >= -1e-5 * lost[-1]
    assert lost[-1] > 0.0


def test_the_flow_and_its_derivatives_are_those_of_its_equation() -> None:
    slopes = (two_sided_by_y, two_sided_by_xi, two_sided_by_n, two_sided_by_out, two_sided_by_back)
    for n in (1.3, 2.0, 3.7):
        for out, back in ((-0.3, 1.7), (1e-4, 2.0), (0.4, 0.0), (20.0, -0.2), (-1.0, -0.3)):
            for y in (-1.1, -0.05, 0.4, 0.9, 3.0):
                for xi in (1e-4, 0.05, 0.4):
                    at = (y, xi, n, out, back)
                    end = two_sided_flow(*at)
                    if abs(end) > 5.0 or (y > 1.0 and out < 0.0):
                        continue
                    for k, slope in enumerate(slopes):
                        up, down = (
                            two_sided_flow(*(value + sign * 1e-6 * (i == k) for i, value in enumerate(at)))
                            for sign in (1, -1)
                        )
                        assert slope(end, *at) == pytest.approx((up - down) / 2e-6, rel=1e-5, abs=1e-6), (at, k)
                    half = two_sided_flow(two_sided_flow(y, 0.4 * xi, n, out, back), 0.6 * xi, n, out, back)
                    assert half == pytest.approx(end, rel=1e-9, abs=1e-12)


def test_from_beyond_its_limit_the_state_falls_back_and_has_its_derivatives() -> None:
    n, out, y, xi = 1.6, -0.5, 1.55, 0.3  # the limit is 1.5422
    at = (y, xi, n, out, 2.0)
    exact = solve_ivp(lambda _, u: 1.0 + out * u**n, (0.0, xi), [y], rtol=1e-10, atol=1e-12).y[0, -1]
    assert two_sided_flow(*at) == pytest.approx(exact, abs=1e-5)
    slopes = (two_sided_by_y, two_sided_by_xi, two_sided_by_n, two_sided_by_out)
    for k, slope in enumerate(slopes):
        up, down = (two_sided_flow(*(v + sign * 1e-6 * (i == k) for i, v in enumerate(at))) for sign in (1, -1))
        assert slope(two_sided_flow(*at), *at) == pytest.approx((up - down) / 2e-6, rel=1e-5, abs=1e-6), k


def test_the_printed_letters_come_back_or_are_refused() -> None:
    model = HardeningBoucWen(**NUMBERS)
    there = to_printed(model, A=250.0)
    again = from_printed(there.c0, there.k0, there.alpha, there.A, there.beta, there.gamma, there.n)
    assert vars(again) == pytest.approx(vars(model), rel=1e-12)
    assert there.beta + there.gamma < 0.0
    good = {"c0": 0.0, "k0": 0.0, "alpha": 1.0, "A": 1.0, "beta": -3.0, "gamma": 1.0, "n": 1.5}
    for bad in ({"gamma": 0.0}, {"A": -1.0}, {"alpha": 0.0}, {"beta": 0.1}):
        with pytest.raises(InputError, match="makes energy"):
            from_printed(**(good | bad))
    with pytest.raises(InputError, match="A = 0"):
        to_printed(model, A=0.0)


@pytest.mark.prove
def test_a_fit_of_six_sines_gives_the_numbers_back() -> None:
    assert_found_again(NAME, NUMBERS | {"n": 2.0})


def test_leaderboards_try_it_only_by_name() -> None:
    assert part(NAME).not_tried
    assert not _is_tried(NAME)
    assert _is_tried("bouc_wen")


def test_a_motion_that_is_infinite_or_not_a_number_ends_the_step() -> None:
    """A response without bound hung there."""
    assert not two_sided_flow(0.1, math.nan, 2.0, 0.5, 2.5) > 0.1  # as it was, or not a number
    assert not math.isfinite(two_sided_flow(0.1, math.inf, 2.0, 0.5, 2.5))
    assert two_sided_flow(1e31, 0.1, 2.0, 0.5, 2.5) == math.inf
