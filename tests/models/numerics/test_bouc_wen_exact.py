"""The Bouc-Wen state along a path: short steps, phases and the closed forms agree, and so do their derivatives."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from tests.models.numerics.bouc_wen_phases import by_phases

from dampyr.models.numerics import bouc_wen_exact
from dampyr.models.numerics.bouc_wen_exact import (
    flow,
    flow_any,
    flow_by_c,
    flow_by_n,
    phase_back,
)


def cases(count: int = 600) -> list[tuple[float, float, float, float]]:
    rng = np.random.default_rng(0)
    rows = []
    for k in range(count):
        y = rng.uniform(-1.0, 0.999) if k % 3 else 1.0 - 10.0 ** rng.uniform(-9, -1)
        rows.append((y, 10.0 ** rng.uniform(-3, 0.3), rng.uniform(1.01, 5.0), 2.0 * rng.uniform(0.3, 3.0) - 1.0))
    return rows


def test_short_steps_and_phases_are_the_same_flow() -> None:
    assert max(abs(flow_any(*case) - by_phases(*case)) for case in cases()) < 1e-12


def test_many_steps_make_one() -> None:
    for y, xi, n, c in cases(100):
        walked = y
        for _ in range(50):
            walked = flow(walked, xi / 50, n, c)
        assert walked == pytest.approx(flow(y, xi, n, c), abs=2e-12)


@pytest.mark.parametrize(("y", "xi", "n", "c"), [(-0.9, 1.4, 1.4, 2.2), (0.3, 0.5, 2.7, 0.4), (-0.7, 0.2, 3.3, 5.0)])
def test_a_solver_in_small_steps_agrees(y: float, xi: float, n: float, c: float) -> None:
    def rate(_: float, s: np.ndarray) -> np.ndarray:
        return np.where(s < 0, 1.0 + c * np.abs(s) ** n, 1.0 - np.abs(s) ** n)

    solution = solve_ivp(rate, (0.0, xi), [y], "DOP853", rtol=1e-12, atol=1e-13, max_step=xi / 200)
    assert flow(y, xi, n, c) == pytest.approx(solution.y[0, -1], abs=1e-8)


def test_derivatives_by_the_exponent_and_the_shape() -> None:
    for y, xi, n, c in cases(200):
        end = flow_any(y, xi, n, c)
        by_n = (by_phases(y, xi, n + 1e-5, c) - by_phases(y, xi, n - 1e-5, c)) / 2e-5
        by_c = (by_phases(y, xi, n, c + 1e-5) - by_phases(y, xi, n, c - 1e-5)) / 2e-5
        assert flow_by_n(end, y, xi, n, c) == pytest.approx(by_n, abs=1e-7)
        assert flow_by_c(end, y, xi, n, c) == pytest.approx(by_c, abs=1e-7)


def missed_by(y: float, xi: float, n: float, c: float) -> float:
    """How far the state after ``xi`` is from the right one, by the integral of 1/(1 + c u^n) from -end to -y; in ln(1 - u)."""

    def of_path(s: float) -> float:
        power = n * np.log1p(-np.exp(s))  # ln u^n
        return np.exp(s) / (-np.expm1(power) + (1.0 + c) * np.exp(power))  # 1 + c u^n without cancellation

    end = flow(y, xi, n, c)
    path, _ = quad(of_path, np.log(1.0 + y) if y > -1.0 else -60.0, np.log(1.0 + end), epsabs=1e-14, limit=500)
    return abs(path - xi) * (1.0 + c * (-end) ** n)


@pytest.mark.parametrize("n", [1.0, 1.5, 2.5, 10.0, 50.0])
def test_the_way_back_where_the_shape_is_extreme(n: float) -> None:
    """Beside sigma = 1/2, where c is nearly 0, and down to where friction hardly leaves its limit."""
    worst, taken = 0.0, 0
    for sigma in (1e-9, 5e-6, 5e-4, 5e-3, 0.1, 0.5 - 5e-9, 0.5, 0.5 + 5e-13, 0.5 + 5e-12, 0.5 + 5e-9, 1.0, 100.0):
        for y in (-1.0, -0.999, -0.7):
            for xi in (0.01, 0.3, 1.0, 3.0, 6.0):
                if flow(y, xi, n, 2.0 * sigma - 1.0) < -1e-6:
                    worst, taken = max(worst, missed_by(y, xi, n, 2.0 * sigma - 1.0)), taken + 1
    assert taken > 40
    assert worst < 1e-12


@pytest.mark.parametrize("c", [2.5, 23.2, 1999.0])
@pytest.mark.parametrize("n", [1.0, 1.0000001, 1.722, 3.5, 12.0])
def test_the_phase_of_a_stiff_way_back_is_its_integral(n: float, c: float) -> None:
    for u in (0.3, 0.9, 1.0):
        kink = min((1.0 / c) ** (1.0 / n), u)  # there the integrand begins to fall
        sides = (0.0, kink), (kink, u)
        parts = [
            quad(lambda s: 1.0 / (1.0 + c * s**n), *ends, epsabs=0.0, epsrel=1e-13, limit=200)[0] for ends in sides
        ]
        assert phase_back(u, n, c) == pytest.approx(sum(parts), rel=1e-11)


def test_a_long_step_takes_few_series(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = [0]
    for name in ("phase_low", "phase_high", "phase_near"):
        series = getattr(bouc_wen_exact, name)

        def summed(*given: float, series=series) -> float:
            counts[0] += 1
            return series(*given)

        monkeypatch.setattr(bouc_wen_exact, name, summed)
    rng, each = np.random.default_rng(3), []
    for _ in range(300):
        shape = rng.uniform(1.05, 4.0), 2.0 * 10.0 ** rng.uniform(-0.5, 1.2) - 1.0
        before = counts[0]
        flow_any(rng.uniform(-1.0, 0.99), 10.0 ** rng.uniform(-1.5, 0.8), *shape)
        each.append(counts[0] - before)
    assert max(each) <= 8  # 61 where Newton's method went on to rounding from afar
    assert np.mean(each) < 3.0
