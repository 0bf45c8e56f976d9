# Choi, Lee and Park, J. Sound and Vibration 245 (2001) 375: a polynomial of the velocity for each sign of the acceleration.
"""The polynomial model: the published force away from reversals, its jump there, and what a fit finds."""

import numpy as np
import pytest
from tests.models.parts.found_again import assert_found_again, damper

NUMBERS = {"p0": 40.0, "p1": 160.0, "p2": -30.0, "p3": -35.0, "p4": 9.0, "p5": 6.0, "p6": -1.0, "vh": 0.004}
P = [NUMBERS[f"p{i}"] for i in range(7)]


def along(v: np.ndarray, **changes: float) -> np.ndarray:
    return damper("choi_polynomial", NUMBERS | changes).force(
        np.arange(v.size) * 1e-3, np.zeros(v.size), voltage=0.0, velocity=v
    )


def published(v: np.ndarray, rises: np.ndarray) -> np.ndarray:
    """The sum of a_i v^i of the source, v in m/s: one set where the acceleration is positive, another where it is not."""
    a = np.array(P) / 0.1 ** np.arange(7)
    b = a * (-1.0) ** (np.arange(7) + 1)
    return np.where(rises, np.polynomial.polynomial.polyval(v, a), np.polynomial.polynomial.polyval(v, b))


@pytest.mark.usefixtures("plain")
def test_beyond_two_vh_after_a_reversal_it_is_the_published_force() -> None:
    phase = np.linspace(0.0, 6 * np.pi, 1_201)
    v = 0.12 * np.sin(phase)
    rises = np.cos(phase) > 0.0
    last = phase > 2 * np.pi
    away = last & (0.12 - np.abs(v) > 2 * NUMBERS["vh"]) | last & (v * np.cos(phase) > 0.0) & (0.12 - np.abs(v) > 1e-6)
    force = along(v)
    np.testing.assert_allclose(force[away], published(v, rises)[away], atol=1e-9)
    assert np.count_nonzero(away) > 600


@pytest.mark.usefixtures("plain")
def test_the_jump_of_the_source_is_a_ramp_over_two_vh() -> None:
    v = 0.1 + NUMBERS["vh"] * np.array([-3.0, -2.0, 0.0, -0.5, -1.0, -2.0, -3.0])
    got, jump = along(v), sum(2.0 * P[i] for i in (0, 2, 4, 6))
    u = v / 0.1
    w = np.array([0.0, 1.0, 1.0, 0.5, 0.0, -1.0, -1.0])
    expected = P[1] * u + P[3] * u**3 + P[5] * u**5 + w * (P[0] + P[2] * u**2 + P[4] * u**4 + P[6] * u**6)
    np.testing.assert_allclose(got, expected, atol=1e-9)
    sharp = along(np.array([0.0999, 0.1, 0.1 - 1e-9]), vh=1e-12)
    assert sharp[1] - sharp[2] == pytest.approx(jump, rel=1e-6)


@pytest.mark.usefixtures("plain")
def test_turned_round_it_is_the_same_damper() -> None:
    v = 0.1 * np.sin(np.linspace(0.0, 20.0, 400))
    np.testing.assert_allclose(along(-v), -along(v), atol=1e-12)


@pytest.mark.prove
def test_a_fit_of_six_sines_gives_the_numbers_back() -> None:
    assert_found_again("choi_polynomial", NUMBERS)
