# Closed forms of the Dahl and Bouc-Wen models: Ikhouane and Rodellar, Systems with Hysteresis (Wiley, 2007).
"""The four closed forms that any implementation must meet."""

import math

import numpy as np
import pytest
from tests.models.parts.dahl_and_bouc_wen import bouc_wen, cycle, dahl

from dampyr.models import Damper
from dampyr.models.parts.bouc_wen import BoucWen, PrintedBoucWen, from_printed


def test_the_limit_cycle_of_dahl_turns_at_minus_tanh() -> None:
    A, rho = 0.004, 180.0
    t, x, v = cycle(A, 3.0, 1000, cycles=40)
    w = dahl(0.0, 1.0, rho).force(t, x, voltage=0.0, velocity=v)
    lower = len(t) - 1 - 500
    assert x[lower] == pytest.approx(-A, rel=1e-12)
    assert w[lower] == pytest.approx(-math.tanh(rho * A), rel=1e-9)


def test_the_energy_of_a_dahl_cycle() -> None:
    A, omega, kx, kw, rho = 0.01, 4.0, 800.0, 50.0, 900.0
    t, x, v = cycle(A, omega, 40_000, cycles=6)
    force = dahl(kx, kw, rho).force(t, x, voltage=0.0, velocity=v)
    last = slice(-40_001, None)
    energy = np.trapezoid(force[last] * v[last], t[last])
    exact = math.pi * kx * omega * A**2 + 4 * kw * (A - math.tanh(rho * A) / rho)
    assert energy == pytest.approx(exact, rel=1e-6)


def test_the_ultimate_state_of_figure_2_2() -> None:
    figure = PrintedBoucWen(c0=0.0, k0=0.0, alpha=0.1, A=1.0, beta=0.1, gamma=2.0, n=1.3)
    assert figure.z_max == pytest.approx((1.0 / 2.1) ** (1 / 1.3), rel=1e-12)
    assert round(figure.z_max, 5) == 0.56512
    model = from_printed(**vars(figure))
    t = np.array([0.0, 1.0])
    far = bouc_wen(model).force(t, np.array([0.0, 100.0]), voltage=0.0, velocity=np.zeros(2))
    assert far[-1] == pytest.approx(0.1 * figure.z_max, rel=1e-9)


@pytest.mark.parametrize(
    ("n", "sigma"),
    [
        pytest.param(n, sigma, marks=[] if (n, sigma) in ((1.3, 0.5), (2.0, 1.9), (3.7, 8.0)) else [pytest.mark.prove])
        for n in (1.0, 1.3, 2.0, 3.7)
        for sigma in (0.5, 1.0, 1.9, 8.0, 600.0)
    ],
)
def test_bouc_wen_along_a_path_against_an_independent_solver(n: float, sigma: float) -> None:
    from scipy.integrate import solve_ivp

    rho, w0 = 300.0, -0.4
    x = np.array([0.0, 0.004, -0.003, 0.0005, -0.009, 0.02])
    with np.errstate(all="raise"):
        ours = bouc_wen(BoucWen(0.0, 0.0, 1.0, rho, sigma, n)).force(
            np.arange(6.0), x, voltage=0.0, velocity=np.zeros(6), state0=[w0]
        )
    w, theirs = w0, [w0]
    for step in np.diff(x):
        s = math.copysign(1.0, step)

        def slope(_: float, y: np.ndarray, s: float = s) -> list[float]:
            w = y[0]
            return [rho * (s - sigma * abs(w) ** (n - 1) * w + (sigma - 1) * s * abs(w) ** n)]

        w = solve_ivp(slope, (0, abs(step)), [w], method="DOP853", rtol=1e-12, atol=1e-13).y[0, -1]
        theirs.append(w)
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


@pytest.mark.parametrize("parts", ["dahl", "bouc_wen"])
def test_a_time_warp_of_the_same_path_gives_the_same_state(parts: str) -> None:
    laws = {"dahl.kx": 0.0, "dahl.kw": 1.0, "dahl.rho": 400.0}
    if parts == "bouc_wen":
        laws = {"bouc_wen.c0": 0.0, "bouc_wen.k0": 0.0, "bouc_wen.kw": 1.0}
        laws |= {"bouc_wen.rho": 400.0, "bouc_wen.sigma": 1.4, "bouc_wen.n": 1.7}
    damper = Damper(parts, laws)
    path = np.linspace(0.0, 1.0, 4001)
    x = 0.01 * np.sin(9 * path) * np.cos(23 * path)
    straight = damper.force(path, x, voltage=0.0)
    warped = damper.force(np.expm1(3 * path**2) + path, x, voltage=0.0)
    np.testing.assert_allclose(warped, straight, atol=1e-12)
