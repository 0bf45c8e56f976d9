# Section 2.4 of Raminelli (2020): kx = 0.045 N s/cm, kw = 6.32 N, rho = 705.32 1/cm, 0.8 cm at 0.2 Hz, 0.125 ms samples.
"""The numerical example of the limit-cycle method, exactly and as it was published."""

import numpy as np
import pytest
from tests.references.branch_of_section_2_4 import KW, KX, RHO, A, branch

from dampyr.identification import limit_cycle


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
