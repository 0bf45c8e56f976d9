"""The power law against the closed form of its energy, and as the two numbers of a fit."""

from math import gamma
from pathlib import Path

import numpy as np
import pytest

from dampyr import records
from dampyr.identification import fit
from dampyr.models import Damper

CASE = Path(__file__).resolve().parents[4] / "shared" / "findings" / "cases" / "power_law_0.3"


def damper(C: float, alpha: float) -> Damper:
    return Damper("power_law", {"power_law.C": C, "power_law.alpha": alpha})


@pytest.mark.parametrize("alpha", [0.15, 0.3, 0.5, 1.0, 2.0])
def test_the_energy_of_a_cycle_is_that_of_the_closed_form(alpha: float) -> None:
    A, omega, n = 0.01, 2 * np.pi, 200_000
    t = np.linspace(0.0, 1.0, n + 1)
    x, v = A * np.sin(omega * t), A * omega * np.cos(omega * t)
    force = damper(1000.0, alpha).force(t, x, voltage=0.0, velocity=v)
    peak = 1000.0 * (A * omega) ** alpha
    factor = 4.0 * 2.0**alpha * gamma(1.0 + 0.5 * alpha) ** 2 / gamma(2.0 + alpha)
    assert np.trapezoid(force * v, t) == pytest.approx(factor * peak * A, rel=1e-5)


def test_beside_the_power_it_is_off_by_what_its_page_says() -> None:
    v = np.array([1e-4, 1e-3, 1e-2, 1.0])
    for alpha in (0.15, 0.3, 0.7):
        force = damper(1.0, alpha).force(np.arange(4.0), np.zeros(4), voltage=0.0, velocity=v)
        off = np.abs(force / v**alpha - 1.0)
        assert off[0] < 5e-3
        assert np.all(off[1:] < 5e-5)


@pytest.mark.skipif(not CASE.exists(), reason="the folder shared with its cases is not beside the repository")
def test_the_two_numbers_of_five_sines_are_found() -> None:
    """F = 1000 N (s/mm)^0.3 sgn v |v|^0.3: at 1 m/s it is 1000 * 1000^0.3 N."""
    result = fit([records.read(path, voltage=0.0) for path in sorted(CASE.glob("*.csv"))], "power_law")
    assert result.parameters["power_law.C"] == pytest.approx(1000.0 * 1000.0**0.3, rel=1e-3)
    assert result.parameters["power_law.alpha"] == pytest.approx(0.3, rel=1e-3)
    assert max(score.l1 for score in result.scores.values()) < 1e-3
