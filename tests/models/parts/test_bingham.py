# Stanway, Sproston and Stevens, J. Electrostatics 20 (1987) 167; Papanastasiou, J. Rheology 31 (1987) 385.
"""The Bingham model: its published limit, and its energy."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper

C0, FC = 650.0, 90.0


def bingham(v0: float) -> Damper:
    return Damper("bingham", {"bingham.c0": C0, "bingham.fc": FC, "bingham.v0": v0})


def test_the_force_is_the_published_one_but_for_an_exponential_near_rest() -> None:
    v0 = 0.004
    v = np.linspace(-0.1, 0.1, 2001)
    force = bingham(v0).force(np.arange(v.size) * 1.0, np.zeros(v.size), voltage=0.0, velocity=v)
    published = C0 * v + FC * np.sign(v)
    np.testing.assert_allclose(published - force, FC * np.sign(v) * np.exp(-np.abs(v) / v0), atol=1e-10)
    assert force[1000] == 0.0


def test_the_energy_of_a_cycle_in_the_published_limit() -> None:
    A, omega = 0.01, 5.0
    t = np.linspace(0.0, 2 * np.pi / omega, 200_001)
    x, v = A * np.sin(omega * t), A * omega * np.cos(omega * t)
    energy = np.trapezoid(bingham(1e-6).force(t, x, voltage=0.0, velocity=v) * v, t)
    assert energy == pytest.approx(np.pi * C0 * omega * A**2 + 4 * FC * A, rel=1e-7)


@pytest.mark.prove
def test_a_fit_gives_the_parameters_back() -> None:
    fit_result = fit(sine(bingham(0.006), 0.0), "bingham")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([C0, FC, 0.006], rel=1e-6)


@pytest.mark.prove
def test_the_published_model_is_fitted_by_holding_v0() -> None:
    fit_result = fit(sine(bingham(1e-5), 0.0), "bingham", fixed={"bingham.v0": 1e-5})
    assert [fit_result.parameters["bingham.c0"], fit_result.parameters["bingham.fc"]] == pytest.approx(
        [C0, FC], rel=1e-6
    )
