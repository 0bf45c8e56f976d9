"""Nigam and Jennings (1969), exact piecewise-linear response; Chopra, Dynamics of Structures: El
Centro, 2 % damping, T = 0.5 s and 2 s."""

import math

import numpy as np
import pytest

from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.structures import Building, respond


def oscillator(period: float) -> Building:
    omega = 2 * math.pi / period
    return Building([[1.0]], [[2 * 0.02 * omega]], [[omega**2]])


@pytest.mark.parametrize(("period", "inside", "sampled"), [(0.5, 0.06825126, 0.0679169), (2.0, 0.18964375, 0.1896102)])
def test_el_centro(period, inside, sampled):
    response = respond(oscillator(period), el_centro(), step=0.0005)
    assert response.peak_displacement[0] == pytest.approx(inside, abs=1e-8)
    assert np.abs(response.displacement[0]).max() == pytest.approx(sampled, abs=6e-8)
    by_default = respond(oscillator(period), el_centro())
    assert by_default.peak_displacement[0] == pytest.approx(inside, rel=2e-5)


@pytest.mark.parametrize(("period", "published"), [(0.5, 0.0679401), (2.0, 0.1896749)])
def test_the_published_values_are_sampled_and_use_another_g(period, published):
    response = respond(oscillator(period), el_centro().scaled(9.81 / 9.80665))
    assert np.abs(response.displacement[0]).max() == pytest.approx(published, abs=1e-7)


@pytest.mark.parametrize("step", [0.05, 0.0125])
def test_a_ramp_of_the_ground_has_a_closed_form(step):
    """a_g = r t: x = -r/omega^2 (t - 2 zeta/omega + transient), exact at every step."""
    period, zeta, rate = 1.3, 0.02, 0.7
    omega = 2 * math.pi / period
    damped = omega * math.sqrt(1 - zeta**2)
    t = np.arange(101) * 0.05
    c = 2 * zeta / omega
    transient = np.exp(-zeta * omega * t) * (
        c * np.cos(damped * t) + (zeta * omega * c - 1) / damped * np.sin(damped * t)
    )
    expected = -rate / omega**2 * (t - c + transient)
    response = respond(oscillator(period), GroundMotion(rate * t, 0.05), step=step)
    assert response.displacement[0] == pytest.approx(expected, abs=1e-12)
