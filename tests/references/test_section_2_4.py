# Section 2.4 of Raminelli (2020): kx = 0.045 N s/cm, kw = 6.32 N, rho = 705.32 1/cm, 0.8 cm at 0.2 Hz, 0.125 ms samples.
"""The numerical example of the limit-cycle method, exactly and as it was published."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.identification import limit_cycle
from dampyr.models import Damper

KX, KW, RHO = 4.5, 6.32, 70532.0
A, F, DT = 0.008, 0.2, 1.25e-4


def branch(phase: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The loading branch, its first sample ``phase`` samples after the lower turning point; forward-difference velocity."""
    omega = 2 * np.pi * F
    t = (np.arange(60_001) + phase) * DT
    x = -A * np.cos(omega * t)
    v = (-A * np.cos(omega * (t + DT)) - x) / DT
    force = Damper("dahl", {"dahl.kx": KX, "dahl.kw": KW, "dahl.rho": RHO}).force(t, x, voltage=0.0, velocity=v)
    rising = slice(40_000, 60_000)
    return x[rising], force[rising], v[rising]


def test_the_example_comes_back_to_a_millionth() -> None:
    x, force, v = branch(0.0)
    estimate = limit_cycle(x, force, v)
    assert estimate.kx == pytest.approx(KX, rel=1e-6)
    assert estimate.a == pytest.approx(KW * RHO, rel=1e-6)
    assert estimate.rho == pytest.approx(RHO, rel=1e-6)
    assert estimate.kw == pytest.approx(KW, rel=1e-6)
    assert estimate.rho_range == pytest.approx((RHO, RHO), rel=1e-5)
    assert estimate.x_star == pytest.approx(-A + np.log(2.0) / RHO, rel=1e-7)


def test_the_velocities_of_step_2() -> None:
    _x, force, v = branch(0.0)
    assert f"{100 * v[0]:.4e}" == "7.8957e-05"
    assert round(float(force[0]), 3) == pytest.approx(-6.320)


@pytest.mark.parametrize(("phase", "a"), [(0.14, 4466.3), (0.0, 4449.4)])
def test_the_published_slope_depends_on_where_a_sample_falls(phase: float, a: float) -> None:
    x, force, v = branch(phase)
    estimate = limit_cycle(x, force, v, kx=KX, nearest=True, x_star1=-0.002092)
    assert estimate.a / 100 == pytest.approx(a, abs=0.06)
    assert estimate.kw == pytest.approx(6.32, abs=0.005)


def test_the_published_rho() -> None:
    x, force, v = branch(0.14)
    assert limit_cycle(x, force, v, kx=KX, nearest=True, x_star1=-0.002092).rho / 100 == pytest.approx(
        706.687, abs=0.01
    )


def test_turning_points_without_velocity_are_refused() -> None:
    x, force, v = branch(0.0)
    v[0] = v[-1] = 0.0
    with pytest.raises(InputError, match="give kx"):
        limit_cycle(x, force, v)


def test_an_offset_that_hides_the_zero_is_named() -> None:
    x, force, v = branch(0.0)
    with pytest.raises(InputError, match="does not cross zero"):
        limit_cycle(x, force + 100.0, v, kx=KX)


def test_the_second_point_is_chosen_on_the_rise_even_where_theta_falls_again() -> None:
    x, force, v = branch(0.0)
    falling = force - 0.5 * KW * (x - x[0]) / (x[-1] - x[0])
    estimate = limit_cycle(x, falling, v, kx=KX)
    assert estimate.x_star1 < -A + 3.0 / RHO
    assert estimate.rho == pytest.approx(RHO, rel=0.05)
    assert estimate.rho_range == pytest.approx((RHO, RHO), rel=0.05)
