# Iwan, J. Applied Mechanics 33 (1966) 893; Masing's rules; Al-Bender, Lampaert and Swevers, IEEE TAC 50 (2005) 1883.
"""The Maxwell-slip model: the virgin curve, Masing's branches, closed inner loops, the energy of a cycle."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper

KW, RHO = 100.0, 500.0


def damper(kx: float = 0.0) -> Damper:
    return Damper("maxwell_slip", {"maxwell_slip.kx": kx, "maxwell_slip.kw": KW, "maxwell_slip.rho": RHO})


def along(x: np.ndarray) -> np.ndarray:
    return damper().force(np.arange(x.size) * 1.0, x, voltage=0.0, velocity=np.zeros(x.size))


def virgin(x: np.ndarray) -> np.ndarray:
    """The four springs, each until it slips."""
    slips = np.array([1, 3, 5, 7]) / (4 * RHO)
    return KW * RHO / 4 * np.minimum(x[:, None], slips).sum(axis=1)


def test_the_first_loading_is_the_parabola_within_a_sixty_fourth() -> None:
    x = np.linspace(0.0, 2 / RHO, 801)
    off = along(x) - KW * (RHO * x - (RHO * x) ** 2 / 4)
    assert off.max() == pytest.approx(KW / 64, rel=1e-4)
    assert off.min() > -1e-10
    assert along(np.array([0.0, 1e-6]))[1] == pytest.approx(KW * RHO * 1e-6)


def test_a_branch_after_a_reversal_is_the_virgin_curve_twice_as_large() -> None:
    top = 1.3 / RHO
    x = np.concatenate((np.linspace(0.0, top, 50), np.linspace(top, -top, 400)[1:]))
    force = along(x)
    np.testing.assert_allclose(force[49:], virgin(np.array([top])) - 2 * virgin((top - x[49:]) / 2), atol=1e-10)


def test_an_inner_loop_closes_and_is_forgotten() -> None:
    straight = along(np.array([0.0, 0.002, 0.003]))
    looped = along(np.array([0.0, 0.002, 0.0013, 0.002, 0.003]))
    assert looped[3] == pytest.approx(straight[1], rel=1e-12)
    assert looped[4] == pytest.approx(straight[2], rel=1e-12)


def test_the_energy_of_a_cycle_whatever_its_sampling() -> None:
    A, fy, slips = 0.01, KW * np.array([1, 3, 5, 7]) / 16, np.array([1, 3, 5, 7]) / (4 * RHO)
    phase = np.linspace(0.0, 6 * np.pi, 3 * 20_000 + 1)
    x = A * np.cos(phase)
    force = along(x)
    last = slice(-20_001, None)
    assert np.trapezoid(force[last], x[last]) == pytest.approx(4 * np.sum(fy * (A - slips)), rel=1e-6)
    np.testing.assert_allclose(along(x[::10_000]), force[::10_000], atol=1e-10)


@pytest.mark.prove
def test_a_fit_gives_the_parameters_back() -> None:
    fit_result = fit(sine(damper(700.0), 0.0), "maxwell_slip")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([700.0, KW, RHO], rel=1e-4)
