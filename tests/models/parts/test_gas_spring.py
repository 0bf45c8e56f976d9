# The polytropic law p V**gamma = constant, for a rod of section a entering a closed volume of gas.
"""The gas spring against the law of its gas."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper


def damper(f0: float, L: float, gamma: float) -> Damper:
    return Damper("gas_spring", {"gas_spring.f0": f0, "gas_spring.L": L, "gas_spring.gamma": gamma})


def test_the_force_on_the_rod_is_the_change_of_the_pressure_times_its_section() -> None:
    section, volume, pressure, gamma = 8e-5, 1.2e-5, 2.1e6, 1.31
    x = np.linspace(-0.1, 0.4, 501)
    gas = pressure * (volume / (volume + section * x)) ** gamma
    force = damper(pressure * section, volume / section, gamma).force(np.arange(501.0), x, voltage=0.0)
    np.testing.assert_allclose(force, (pressure - gas) * section, atol=1e-10)


def test_it_resists_both_ways_and_is_stiffer_in_compression() -> None:
    x = np.array([-0.05, -1e-7, 0.0, 1e-7, 0.05])
    force = damper(170.0, 0.15, 1.4).force(np.arange(5.0), x, voltage=0.0)
    assert force[0] < 0.0 < force[4]
    assert -force[0] > force[4]
    assert force[2] == 0.0
    assert (force[3] - force[1]) / 2e-7 == pytest.approx(1.4 * 170.0 / 0.15, rel=1e-6)


def test_where_no_gas_volume_is_left_there_is_no_number() -> None:
    force = damper(170.0, 0.15, 1.4).force(np.arange(3.0), np.array([0.0, -0.149, -0.151]), voltage=0.0)
    assert np.isfinite(force[1])
    assert np.isnan(force[2])


@pytest.mark.prove
def test_a_fit_with_a_known_exponent_gives_the_gas_back() -> None:
    truth = damper(300.0, 0.04, 1.3)
    fit_result = fit(sine(truth, 0.0, amplitude=0.02), "gas_spring", fixed={"gas_spring.gamma": 1.3})
    assert fit_result.converged, fit_result.reason
    assert fit_result.parameters["gas_spring.f0"] == pytest.approx(300.0, rel=1e-5)
    assert fit_result.parameters["gas_spring.L"] == pytest.approx(0.04, rel=1e-5)
