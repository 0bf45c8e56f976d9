# Chopra, Dynamics of Structures (2017): the bilinear loop of yielding systems; OpenSees 3.7.1, its Steel01.
"""The bilinear model: its corners, the energy of a cycle, its letters, and what a fit finds."""

import numpy as np
import pytest
from tests.models.parts.found_again import assert_found_again, damper

NUMBERS = {"Q": 150.0, "uy": 8e-4, "k2": 9000.0}
Q, UY, K2 = NUMBERS.values()


def along(x: np.ndarray, **changes: float) -> np.ndarray:
    return damper("bilinear", NUMBERS | changes).force(
        np.arange(len(x)) * 1.0, x, voltage=0.0, velocity=np.zeros(len(x))
    )


@pytest.mark.usefixtures("plain")
def test_its_corners_are_those_of_the_initial_stiffness_and_the_yield_force() -> None:
    k1 = K2 + Q / UY
    x = np.array([0.0, 0.5 * UY, UY, 0.01, 0.01 - 2 * UY, -0.01, -0.01 + UY, 0.0])
    expected = [
        0.0,
        0.5 * k1 * UY,
        k1 * UY,
        Q + K2 * 0.01,
        -Q + K2 * (0.01 - 2 * UY),
        -Q - K2 * 0.01,
        -K2 * (0.01 - UY),
        Q,
    ]
    np.testing.assert_allclose(along(x), expected, atol=1e-9)
    assert k1 * UY == pytest.approx(Q + K2 * UY)


@pytest.mark.prove
def test_the_energy_of_a_cycle_is_the_parallelogram_whatever_its_sampling() -> None:
    A = 0.006
    x = A * np.sin(np.linspace(0.0, 6 * np.pi, 3 * 20_000 + 1))
    force = along(x)
    last = slice(-20_001, None)
    assert np.trapezoid(force[last], x[last]) == pytest.approx(4 * Q * (A - UY), rel=1e-6)
    np.testing.assert_allclose(along(x[::5_000]), force[::5_000], atol=1e-9)


@pytest.mark.usefixtures("plain")
def test_below_yield_it_is_a_spring() -> None:
    x = UY * np.sin(np.linspace(0.0, 20.0, 300))
    np.testing.assert_allclose(along(x), (K2 + Q / UY) * x, atol=1e-10)


@pytest.mark.prove
def test_what_is_not_stored_is_only_dissipated() -> None:
    nodes = np.cumsum(2e-4 * np.random.default_rng(0).standard_normal(500))
    x = np.interp(np.linspace(0.0, 499.0, 100 * 499 + 1), np.arange(500.0), nodes - nodes[0])
    stuck = (along(x) - K2 * x) / Q
    work = np.cumsum(Q * 0.5 * (stuck[1:] + stuck[:-1]) * np.diff(x))
    lost = work - 0.5 * Q * UY * stuck[1:] ** 2
    assert np.min(np.diff(lost)) >= -1e-5 * lost[-1]  # the trapezium cuts the corner where it yields within a step
    assert lost[-1] > 0.0


@pytest.mark.prove
@pytest.mark.parametrize("numbers", [NUMBERS, {"Q": 900.0, "uy": 3e-3, "k2": 800.0}])
def test_a_fit_of_six_sines_gives_the_numbers_back(numbers: dict[str, float]) -> None:
    assert_found_again("bilinear", numbers)
