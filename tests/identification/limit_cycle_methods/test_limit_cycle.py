"""The limit-cycle method on a loading branch: where it finds its points, and what it refuses."""

import pytest
from tests.references.branch_of_section_2_4 import KW, KX, RHO, A, branch

from dampyr.errors import InputError
from dampyr.identification import limit_cycle


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
