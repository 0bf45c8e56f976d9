# Canudas de Wit, Olsson, Astrom and Lischinsky, A new model for control of systems with friction, IEEE TAC 40 (1995) 419.
"""The LuGre model against an independent solver in the letters of the source, and its published properties."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.identification.synthetic import sine
from tests.models.parts.stribeck_friction import FC, FS, SIGMA0, SIGMA1, SIGMA2, VS, E, damper, motion

from dampyr.identification import fit
from dampyr.models import Damper


def stribeck(v: float) -> float:
    return FC + (FS - FC) * math.exp(-((v / VS) ** 2))


def reference(t: np.ndarray) -> np.ndarray:
    def slope(time: float, z: np.ndarray) -> np.ndarray:
        v = float(motion(np.array(time))[1])
        return v - SIGMA0 * abs(v) / stribeck(v) * z

    z = solve_ivp(slope, (0.0, t[-1]), [0.0], method="DOP853", t_eval=t, rtol=1e-10, atol=1e-14, max_step=0.005).y[0]
    v = motion(t)[1]
    rate = v - SIGMA0 * np.abs(v) * z / np.array([stribeck(one) for one in v])
    return SIGMA0 * z + SIGMA1 * rate + SIGMA2 * v


def error(n: int) -> float:
    t = np.linspace(0.0, 1.5, n + 1)
    x, v = motion(t)
    force = damper().force(t, x, voltage=0.0, velocity=v)
    shown = slice(0, None, n // 150)
    return float(np.sqrt(np.mean((force[shown] - reference(t[shown])) ** 2)))


def test_the_step_is_of_second_order() -> None:
    errors = [error(n) for n in (600, 1200, 2400)]
    assert errors[2] < 2e-4 * FS
    assert errors[0] / errors[1] > 3.0
    assert errors[1] / errors[2] > 3.0


def test_at_constant_speed_one_step_is_exact() -> None:
    v, path = 0.006, 0.0009
    force = damper().force(np.array([0.0, path / v]), np.array([0.0, path]), voltage=0.0, velocity=np.array([v, v]))
    g = stribeck(v)
    z = g / SIGMA0 * (1 - math.exp(-SIGMA0 / g * path))
    assert force[1] == pytest.approx(SIGMA0 * z + SIGMA1 * (v - SIGMA0 * v * z / g) + SIGMA2 * v, rel=1e-12)


@pytest.mark.parametrize("v", [1e-4, 0.005, 0.02, 0.3])
def test_a_steady_speed_gives_the_stribeck_curve(v: float) -> None:
    t = np.array([0.0, 1.0, 2.0])
    force = damper().force(t, np.array([0.0, -1.0, -2.0]), voltage=0.0, velocity=np.full(3, -v))
    assert force[-1] == pytest.approx(-stribeck(v) - SIGMA2 * v, rel=1e-9)


def test_without_excess_and_sigma1_it_is_dahl() -> None:
    t = np.linspace(0.0, 2.0, 777)
    x, v = motion(t)
    dahl = Damper("dahl", {"dahl.kx": SIGMA2, "dahl.kw": FC, "dahl.rho": 900.0})
    ours = damper(sigma1=0.0, e=0.0).force(t, x, voltage=0.0, velocity=v)
    np.testing.assert_allclose(ours, dahl.force(t, x, voltage=0.0, velocity=v), atol=1e-10)


def test_it_is_passive_with_enough_sigma2() -> None:
    t = np.linspace(0.0, 3.0, 30_001)
    x, v = motion(t)
    force = damper(sigma1=4000.0, sigma2=4000.0 * E).force(t, x, voltage=0.0, velocity=v)
    energy = np.concatenate(([0.0], np.cumsum(0.5 * (force[1:] * v[1:] + force[:-1] * v[:-1]) * np.diff(t))))
    assert energy.min() > -1e-6 * energy.max()


@pytest.mark.prove
def test_a_fit_gives_the_parameters_back() -> None:
    truth = damper()
    fit_result = fit(sine(truth, 0.0), "lugre")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([FC, SIGMA1, SIGMA2, 900.0, E, VS], rel=1e-3)
