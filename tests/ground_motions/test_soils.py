"""Filters of the ground: the density as printed, and the two oscillators that it is made of."""

import numpy as np
import pytest
from scipy.signal import TransferFunction, lsim

from dampyr.ground_motions import FIRM, MEDIUM, SOFT, Soil

S0 = 0.01


def test_the_density_is_the_formula_as_printed() -> None:
    g, zg, f, zf, w = 15.0, 0.6, 1.5, 0.6, np.linspace(0.1, 90.0, 200)
    layers = (g**4 + 4 * zg**2 * g**2 * w**2) / ((g**2 - w**2) ** 2 + 4 * zg**2 * g**2 * w**2)
    slow = w**4 / ((f**2 - w**2) ** 2 + 4 * zf**2 * f**2 * w**2)
    np.testing.assert_allclose(FIRM.density(w, S0), S0 * layers * slow, rtol=1e-12)
    assert FIRM.density(0.0) == 0.0


@pytest.mark.parametrize("soil", [FIRM, MEDIUM, SOFT])
def test_the_filters_are_the_two_oscillators(soil: Soil) -> None:
    """One push through the same two oscillators, stepped in time by scipy."""
    dt, t = 0.002, np.arange(20001) * 0.002
    push = np.exp(-0.5 * ((t - 2.0) / 0.05) ** 2)
    g, f = soil.omega_g, soil.omega_f
    layers = TransferFunction([2 * soil.zeta_g * g, g**2], [1, 2 * soil.zeta_g * g, g**2])
    slow = TransferFunction([1, 0, 0], [1, 2 * soil.zeta_f * f, f**2])
    expected = lsim(slow, lsim(layers, push, t)[1], t)[1]
    omega = 2 * np.pi * np.fft.rfftfreq(len(t) * 2, dt)
    ours = np.fft.irfft(soil.transfer(omega) * np.fft.rfft(push, len(t) * 2), len(t) * 2)[: len(t)]
    np.testing.assert_allclose(ours, expected, atol=2e-3 * np.abs(expected).max())
