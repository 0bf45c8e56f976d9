# Canudas de Wit, Olsson, Astrom and Lischinsky, A new model for control of systems with friction, IEEE TAC 40 (1995) 419.
"""The LuGre model against an independent solver in the letters of the source, and its published properties."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.identification.synthetic import sine

from dampyr.errors import DampyrWarning
from dampyr.identification import fit, score
from dampyr.models import Damper

FC, FS, SIGMA0, SIGMA1, SIGMA2, VS = 80.0, 104.0, 80.0 * 900.0, 60.0, 500.0, 0.01
E = FS / FC - 1.0


def damper(**changes: float) -> Damper:
    values = {"fc": FC, "sigma1": SIGMA1, "sigma2": SIGMA2, "rho": SIGMA0 / FC, "e": E, "vs": VS} | changes
    return Damper("lugre", {f"lugre.{key}": value for key, value in values.items()})


def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 0.004 * np.sin(7 * t) + 0.001 * np.sin(23 * t), 0.028 * np.cos(7 * t) + 0.023 * np.cos(23 * t)


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


STIFF = {"sigma1": 0.0, "sigma2": 50.0, "rho": 2e4, "e": 9.0}


@pytest.mark.parametrize("vs", [1e-2, 3e-3, 1e-3])
def test_samples_that_step_over_vs_are_told_with_the_error_that_they_make(vs: float) -> None:
    """200 samples a second, as a campaign has: the figures in the warning are those of 51,200, within a factor of 1.2."""
    t, fine = np.linspace(0.0, 1.5, 301), np.linspace(0.0, 1.5, 300 * 256 + 1)
    stiff = damper(**STIFF, vs=vs)
    (x, v), (fine_x, fine_v) = motion(t), motion(fine)
    exact = stiff.force(fine, fine_x, voltage=0.0, velocity=fine_v)[::256]
    with pytest.warns(DampyrWarning, match=f"crosses {1e3 * vs:.3g} mm/s within a sample at 200 samples") as caught:
        force = stiff.force(t, x, voltage=0.0, velocity=v)
    mean, worst = (float(text) / 100 for text in re.findall(r"by (\S+) % of its", str(caught[0].message)))
    gap = np.abs(force - exact)
    assert mean == pytest.approx(np.mean(gap) / np.mean(np.abs(exact - np.median(exact))), rel=0.2)
    assert worst == pytest.approx(gap.max() / np.abs(exact).max(), rel=0.2)
    assert (worst > 0.48) is (vs == 1e-3)


def test_samples_that_follow_vs_are_not_warned_of(recwarn: pytest.WarningsRecorder) -> None:
    t = np.linspace(0.0, 1.5, 3001)
    x, v = motion(t)
    damper(**STIFF).force(t, x, voltage=0.0, velocity=v)
    assert not recwarn.list


@pytest.mark.prove
def test_fits_and_scores_tell_of_it_too() -> None:
    stiff = damper(**STIFF, vs=1e-3)
    with pytest.warns(DampyrWarning, match="within a sample"):
        coarse = sine(stiff, 0.0)
    with pytest.warns(DampyrWarning, match="within a sample"):
        score(stiff, coarse)
    with pytest.warns(DampyrWarning, match=r"test: .* within a sample"):
        result = fit(coarse, "lugre", fixed={"lugre.vs": 1e-3, "lugre.rho": 2e4, "lugre.sigma1": 0.0})
    assert any("within a sample" in note for note in map(str, result.findings))


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
