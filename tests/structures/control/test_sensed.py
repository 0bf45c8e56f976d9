"""What laws sense and weigh, and where there is none."""

import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.errors import InputError
from dampyr.structures import Building, single_mass, two_storey


def test_energy_is_the_weight_where_none_is_given():
    one = single_mass(300.0, stiffness=2e5, damping_ratio=0.05)
    for name in ("clipped_optimal", "lyapunov"):
        assert sensed(name, building=one) == pytest.approx(sensed(name, building=one, weights=(2e5, 300.0)), rel=1e-12)


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
