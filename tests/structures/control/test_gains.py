"""What the laws sense, against closed forms and plain integrals."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.structures import Building, control_law, single_mass, two_storey
from dampyr.structures.control_laws import gains
from dampyr.structures.propagator import system


def sensed(name, place=1, building=None, **settings):
    building = building or two_storey()
    return gains(control_law(name, high=3.0, **settings), building, building.connection(place))


@pytest.mark.parametrize("name", ["on_off", "skyhook"])
@pytest.mark.parametrize(
    ("place", "expected"),
    [(1, [0, 0, 1, 0, 1]), (2, [0, 0, 0, 1, 1]), ((0, 2), [0, 0, 0, 1, 1]), ((2, 0), [0, 0, 0, -1, -1])],
)
def test_skyhooks_sense_the_absolute_velocity_of_the_upper_floor(name, place, expected):
    assert sensed(name, place).tolist() == expected


@pytest.mark.parametrize(
    ("place", "expected"), [(1, [0, 0, 1, 0, 1]), (2, [0, 0, -1, 1, 0]), ((0, 2), [0, 0, 0, 1, 1])]
)
def test_bang_bang_senses_the_rate_over_still_ground(place, expected):
    assert sensed("bang_bang", place).tolist() == expected


def test_the_optimal_gains_of_one_mass_are_those_of_the_closed_form():
    """Without damping the Riccati equation of one mass is two quadratics, one after the other."""
    m, k, effort = 300.0, 2e5, 0.07
    building = single_mass(m, stiffness=k)
    r, b2, w2 = effort / k, m**-2, k / m
    p12 = (-w2 + np.sqrt(w2**2 + k * b2 / r)) * r / b2
    p22 = np.sqrt((2 * p12 + m) * r / b2)
    expected = [p12 / (m * r), p22 / (m * r), 0.0]
    assert sensed("clipped_optimal", building=building, effort=effort) == pytest.approx(expected, rel=1e-9)


def test_lyapunovs_matrix_solves_its_linear_equations():
    building, weights = two_storey(), (2e3, 1e3, 3.0, 5.0)
    a, _, b = system(building, building.connection(2)[None])
    whole = np.kron(a.T, np.eye(4)) + np.kron(np.eye(4), a.T)
    p = np.linalg.solve(whole, -np.diag(weights).ravel()).reshape(4, 4)
    assert sensed("lyapunov", 2, weights=weights) == pytest.approx([*(-b.T @ p)[0], 0.0], rel=1e-9)


def test_energy_is_the_weight_where_none_is_given():
    one = single_mass(300.0, stiffness=2e5, damping_ratio=0.05)
    for name in ("clipped_optimal", "lyapunov"):
        assert sensed(name, building=one) == pytest.approx(sensed(name, building=one, weights=(2e5, 300.0)), rel=1e-12)


def test_less_effort_asks_for_more_force():
    soft, hard = (sensed("clipped_optimal", effort=effort) for effort in (1.0, 0.01))
    assert np.linalg.norm(hard) > 3 * np.linalg.norm(soft)


@pytest.mark.parametrize(
    ("name", "settings", "building", "message"),
    [
        ("lyapunov", {}, single_mass(300.0, stiffness=2e5), "does not decay by itself"),
        ("lyapunov", {"weights": (1.0, 2.0)}, two_storey(), "give 4 numbers"),
        ("clipped_optimal", {"weights": (0.0, 0.0, 0.0, 0.0)}, two_storey(), "not all 0"),
        ("clipped_optimal", {}, Building([[1.0]], [[0.1]], [[0.0]]), "without springs"),
    ],
)
def test_what_has_no_gains_is_refused(name, settings, building, message):
    with pytest.raises(InputError, match=message):
        sensed(name, building=building, **settings)
