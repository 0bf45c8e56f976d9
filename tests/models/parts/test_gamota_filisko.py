# Gamota and Filisko, J. Rheology 35 (1991) 399, in the letters of Spencer et al. (1997), solved by scipy; the solid of Zener.
"""The extended Bingham model: its equations, the solid before yield, steady sliding, stiff steps, passivity, and a fit."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.models.parts.found_again import assert_found_again, damper

from dampyr.models.parts.gamota_filisko import GamotaFilisko, from_printed, to_printed

PRINTED = {"fc": 150.0, "c0": 1500.0, "k1": 2.5e5, "c1": 1e4, "k2": 5e5}  # N, N s/m, N/m
NUMBERS = {"fc": 150.0, "d": 3e-4, "vc": 0.1, "r": 0.5, "tau": 0.02}


def along(t: np.ndarray, x: np.ndarray, **changes: float) -> np.ndarray:
    return damper("gamota_filisko", NUMBERS | changes).force(t, x, voltage=0.0, velocity=np.zeros(t.size))


def test_the_letters_of_the_source_are_converted_both_ways() -> None:
    assert from_printed(**PRINTED) == GamotaFilisko(**NUMBERS)
    assert to_printed(from_printed(**PRINTED)) == pytest.approx(PRINTED)


def printed(t: np.ndarray, omega: float, A: float) -> np.ndarray:
    """F' = k2 (x' - x1' - (x2 - x1)'), the printed equations for x = A sin(omega t) from rest."""
    fc, c0, k1, c1, k2 = PRINTED.values()

    def rate(s: float, y: np.ndarray) -> list[float]:
        slides = max(abs(y[0]) - fc, 0.0) * np.sign(y[0]) / c0
        creeps = (y[0] - k1 * y[1]) / c1
        return [k2 * (A * omega * np.cos(omega * s) - slides - creeps), creeps]

    return solve_ivp(rate, (t[0], t[-1]), [0.0, 0.0], "LSODA", t_eval=t, rtol=1e-9, atol=1e-9, max_step=1e-3).y[0]


@pytest.mark.prove
def test_the_printed_equations_are_approached_at_second_order() -> None:
    omega, A = 4 * np.pi, 0.01
    errors = []
    for rate in (200, 800, 3200):
        t = np.linspace(0.0, 1.0, rate + 1)
        exact = printed(t, omega, A)
        errors.append(np.sqrt(np.mean((along(t, A * np.sin(omega * t)) - exact) ** 2)) / np.abs(exact).max())
    assert errors[0] < 0.003
    assert errors[1] < errors[0] / 12
    assert errors[2] < errors[1] / 12


@pytest.mark.prove
def test_before_yield_it_is_the_solid_of_zener() -> None:
    _, _, k1, c1, k2 = PRINTED.values()
    omega, A = 30.0, 2e-4
    t = np.linspace(0.0, 20 * 2 * np.pi / omega, 40_001)
    force = along(t, A * np.sin(omega * t))
    assert np.abs(force).max() < PRINTED["fc"]
    solid = k1 + 1j * omega * c1
    expected = np.imag(A * k2 * solid / (k2 + solid) * np.exp(1j * omega * t))
    last = slice(-4_000, None)
    np.testing.assert_allclose(force[last], expected[last], atol=1e-5 * np.abs(expected).max())


@pytest.mark.usefixtures("plain")
def test_a_steady_motion_ends_at_the_force_of_bingham_however_long_the_steps() -> None:
    for dt in (0.02, 0.5, 30.0):
        for v in (0.03, -0.2):
            t = dt * np.arange(61)
            expected = np.copysign(PRINTED["fc"], v) + PRINTED["c0"] * v
            assert along(t, v * t)[-1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.prove
def test_no_path_gives_more_energy_than_it_took() -> None:
    rng = np.random.default_rng(0)
    for _ in range(5):
        nodes = np.append(0.0, 0.004 * rng.standard_normal(60))
        t = np.linspace(0.0, 3.0, 60_001)
        x = np.interp(t, np.linspace(0.0, 3.0, nodes.size), nodes)
        force = along(t, x)
        work = np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x))
        assert np.min(work) >= -1e-9


@pytest.mark.prove
@pytest.mark.parametrize(
    "numbers",
    [
        NUMBERS,
        {"fc": 150.0, "d": 2e-3, "vc": 0.3, "r": 0.2, "tau": 0.1},
        {"fc": 400.0, "d": 1e-3, "vc": 0.05, "r": 1.0, "tau": 0.05},
    ],
)
def test_a_fit_of_six_sines_gives_the_numbers_back(numbers: dict[str, float]) -> None:
    assert_found_again("gamota_filisko", numbers)
