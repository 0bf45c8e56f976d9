# Wereley, Pang and Park, Idealized hysteresis modeling of ER and MR dampers, J. Intell. Mater. Syst. Struct. 9 (1998) 642.
"""The nonlinear biviscous model in the letters of the source, and the energy of its cycle."""

import math

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper

C, FY, VY = 500.0, 120.0, 0.012


def biviscous() -> Damper:
    return Damper("biviscous", {"biviscous.c": C, "biviscous.fy": FY, "biviscous.vy": VY})


def test_the_three_branches_of_the_source() -> None:
    pre = C + FY / VY
    v = np.linspace(-0.06, 0.06, 1201)
    force = biviscous().force(np.arange(v.size) * 1.0, np.zeros(v.size), voltage=0.0, velocity=v)
    published = np.where(v >= VY, C * v + FY, np.where(v <= -VY, C * v - FY, pre * v))
    np.testing.assert_allclose(force, published, atol=1e-10)


def test_the_energy_of_a_cycle() -> None:
    A, omega = 0.01, 4.0
    V = A * omega
    theta = math.asin(VY / V)
    t = np.linspace(0.0, 2 * np.pi / omega, 200_001)
    v = V * np.cos(omega * t)
    energy = np.trapezoid(biviscous().force(t, A * np.sin(omega * t), voltage=0.0, velocity=v) * v, t)
    yielding = 4 * FY / omega * (V**2 / VY * (theta / 2 - math.sin(2 * theta) / 4) + V * math.cos(theta))
    assert energy == pytest.approx(np.pi * C * omega * A**2 + yielding, rel=1e-8)


@pytest.mark.prove
def test_a_fit_gives_the_parameters_back() -> None:
    fit_result = fit(sine(biviscous(), 0.0), "biviscous")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([C, FY, VY], rel=1e-5)
